"""The exported estimator: samples in, estimates out."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vegrip.c99 import LONGS, literals
from vegrip.estimator import ContactEstimator
from vegrip.estimator.compiled import KINDS, clock_text_of
from vegrip.estimator.estimator import quantile
from vegrip.estimator.layout import FRICTION, Layout
from vegrip.estimator.memory import CHANNELS
from vegrip.estimator.origins import Origins
from vegrip.export.precision import MARGIN, PRECISIONS, Request, Unit
from vegrip.messages import NAN, Estimate, FingertipState

INPUTS = (
    "normal_force", "displacement", "tangential_force_x", "tangential_force_y", "torque_z", "temperature",
    "slip", "slip_speed", "contact_radius",
)  # fmt: skip
ESTIMATES = (
    "indentation", "normal_force", "contact_radius", "pressure_exponent", "friction_coefficient",
    "limit_force", "limit_torque", "limit_radius",
)  # fmt: skip
AHEAD = ("lower_bound", "force_reserve", "time_to_slip", "earliest_slip")
OUTPUTS = (
    *(name for one in ESTIMATES for name in (one, f"{one}_std")), "margin", "margin_std",
    *AHEAD, "least_force",
)  # fmt: skip
FLAGS = ("in_contact", *(f"{one}_valid" for one in ESTIMATES), "margin_valid")
STEP = 5e-3  # [s]
SEED = 16


@dataclass(frozen=True)
class Frame:
    """One sample, and what was known after it."""

    stamp: int
    inputs: tuple[float, ...]
    outputs: tuple[float, ...]
    flags: int


@dataclass(frozen=True)
class Vectors:
    """The frames, and the whole memory after the last one."""

    frames: tuple[Frame, ...]
    reals: NDArray[np.float64]


def record(request: Request) -> Vectors:
    """Run the model's own simulation through the estimator; the same numbers every time."""
    estimator = ContactEstimator(request.model, request.noise, request.estimator)
    frames = tuple(_frame(estimator, state) for state in simulated(request))
    return Vectors(frames, estimator.named.f.copy())


def simulated(request: Request) -> Iterator[FingertipState]:
    """Press, hold, load, slip, release and touch again; samples are lost, wrong and late."""
    model, noise, n = request.model, request.noise, request.frames
    rng = np.random.default_rng(SEED)
    t, depth = np.arange(n) * STEP, model.reference_depth
    at = np.array([0.0, 0.06, 0.2, 0.5, 0.56, 0.66, 0.7, 0.76, 1.0]) * n * STEP
    delta = np.interp(t, at, np.array([-0.2, -0.2, 1.0, 1.0, 1.4, 1.4, -0.3, -0.3, 0.8]) * depth)
    force = model.simulate(t, delta).normal_force
    mu = model.values["mu"].value
    share = np.interp(t, at, [0.0, 0.0, 0.3, 0.6, 0.9, 1.0, 0.0, 0.0, 0.4])
    load = mu * share * force
    slips = (share > 0.97) & (force > 0.0)
    shift = 0
    for i in range(n):
        shift += round(1.0e9) if i == int(0.62 * n) else 0  # a second of silence
        missing = rng.uniform(size=2) < 0.03
        jump = 0.3 * depth if i == int(0.4 * n) else 0.0
        backwards = 3 * round(STEP * 1e9) if i == int(0.45 * n) else 0
        yield FingertipState(
            round(t[i] * 1e9) + shift - backwards,
            "tip",
            i,
            normal_force=NAN if missing[0] else float(force[i] + rng.normal(0.0, noise.normal_force)),
            displacement=NAN if missing[1] else float(delta[i] + jump + rng.normal(0.0, noise.displacement)),
            tangential_force_x=float(0.8 * load[i] + rng.normal(0.0, noise.tangential_force)),
            tangential_force_y=float(0.6 * load[i] + rng.normal(0.0, noise.tangential_force)),
            torque_z=float(rng.normal(0.0, noise.torque_z)),
            temperature=NAN if i % 10 else float(model.reference_temperature + math.sin(i / 50.0)),
            slip=1.0 if slips[i] else 0.0,
            slip_speed=1e-3 if slips[i] else 0.0,
            contact_radius=NAN,
        )


def _frame(estimator: ContactEstimator, state: FingertipState) -> Frame:
    contact, margin = estimator.update(state), estimator.slip_margin()
    estimates: list[Estimate] = [getattr(contact, name) for name in ESTIMATES]
    outputs = [number for one in estimates for number in (one.value, one.std)]
    outputs += [margin.margin.value, margin.margin.std, *(getattr(margin, name) for name in AHEAD)]
    outputs.append(estimator.least_force(MARGIN))
    states = [contact.in_contact, *(one.valid for one in estimates), margin.margin.valid]
    flags = sum(1 << bit for bit, true in enumerate(states) if true)
    return Frame(state.stamp, tuple(getattr(state, name) for name in INPUTS), tuple(outputs), flags)


def unit(request: Request) -> Unit:
    """Return what is exported."""
    model, p, reals = request.model, request.prefix, PRECISIONS[request.precision].reals
    vectors, settings = record(request), request.estimator
    blank = ContactEstimator(model, request.noise, settings)
    layout = blank.layout
    entries = {name: KINDS[name] for name in ("assimilate", "margin_of", "least_force")}
    measured = (f"    e->f.named.state.{name} = sample->{name};" for name in CHANNELS)
    words = {
        "recovery": str(settings.recovery), "horizon": f"{settings.horizon:g}",
        "risk": f"{1.0 - settings.confidence:.3g}",
        "quantile": literals.real(quantile(settings.confidence), reals), "margin": literals.real(MARGIN),
        "temperature": f"{model.reference_temperature:g}", "measured": "\n".join(measured),
        "believed": "true", "command": "",
        "row": "frame", "ROW": "FRAME", "worst_sources": f"{p}_worst.c {p}_vectors.c $(OBJECT)",
        **_parameters(request, layout), **_rows(vectors),
    }  # fmt: skip
    text = clock_text_of(model, layout, ellipse=settings.surface == "ellipse")
    entries |= {"informed_age": (LONGS,)}
    return Unit(text, Origins(model.effects), entries, blank.named, vectors.reals, words)


def _parameters(request: Request, layout: Layout) -> dict[str, str]:
    model, p, reals = request.model, request.prefix, PRECISIONS[request.precision].reals
    variances, stds, lines = [], [], []
    for place, (symbol, (effect, declared)) in enumerate(model.parameters.items()):
        value = model.values[symbol]
        variances.append(str(_variance_of(layout, place)))
        stds.append(literals.real(0.0 if np.isnan(value.std) else value.std, reals))
        learned = "learned" if place in layout.learned or place == layout.mu else "as stated"
        doc = f"{effect}: {declared.doc}".replace("*/", "* /")
        lines.append(f"    {p.upper()}_PARAMETER_{symbol}, /* [{declared.unit}] {doc}; {learned} */")
    return {
        "parameters": "\n".join(lines),
        "variance_of": ", ".join(variances),
        "std_of": ", ".join(stds),
    }


def _variance_of(layout: Layout, place: int) -> int:
    """Return where the variance of a parameter lies in the memory, or -1."""
    if place == layout.mu:
        return layout.places()["FRICTION"][0] + FRICTION.index("VAR")
    if place in layout.learned:
        j = layout.learned_from + layout.learned.index(place)
        return layout.places()["P"][0] + j * layout.n + j
    return -1


def _rows(vectors: Vectors) -> dict[str, str]:
    rows = []
    for frame in vectors.frames:
        inputs = ", ".join(literals.hexadecimal(one) for one in frame.inputs)
        outputs = ", ".join(literals.hexadecimal(one) for one in frame.outputs)
        rows.append(f"    {{{frame.stamp}LL, {{{inputs}}},\n     {{{outputs}}}, {frame.flags}U}},")
    return {
        "frames": str(len(vectors.frames)),
        "outputs": str(len(OUTPUTS)),
        "output_names": ", ".join(OUTPUTS),
        "flag_names": ", ".join(FLAGS),
        "rows": "\n".join(rows),
    }
