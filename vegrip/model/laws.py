"""What every effect must hold to, as a check that an author runs: ``broken_laws(EFFECT) == []``.

The catalogue's own tests (``tests/effects``) ask for more; these are the laws that a new effect breaks first.
"""

from collections.abc import Callable, Iterator

import numpy as np

from vegrip.effects.contract import INPUTS, Effect
from vegrip.errors import ModelError
from vegrip.model import ContactModel, paper_model
from vegrip.types import Floats

LAW_SAMPLES = 1500
SAMPLE_PERIOD_S = 2e-3  # [s]


def broken_laws(effect: Effect) -> list[str]:
    """Return a sentence for each law that ``effect`` breaks on the model of the paper; none is good.

    It must be absent at its null values and felt at its defaults, every parameter must move some output,
    compiled and uncompiled code must agree, results must be finite at all bounds of the parameters, a reading
    of the present state (``dt = 0``) must change nothing, and shorter steps must lead to one result.
    """
    try:
        model = paper_model(8e-3).with_effect(effect)
        model.compiled()
    except ModelError as error:
        return [str(error)]
    return [sentence for law in LAWS.values() for sentence in law(effect, model)]


def _declared(effect: Effect, _: ContactModel) -> Iterator[str]:
    if not any(p.null is not None for p in effect.parameters):
        yield "no parameter has a null value, so no test can show whether the effect is there"
    for p in effect.parameters:
        if not p.low <= p.default <= p.high or p.std <= 0.0:
            yield f"{p.symbol}: the default must lie within the bounds, and the prior's std above 0"
    if not effect.cites:
        yield "it cites nothing: say where the equation comes from, be it your own report"


def _absent(effect: Effect, model: ContactModel) -> Iterator[str]:
    for p in effect.parameters:
        if p.null is not None:
            model = model.with_value(p.symbol, p.null)
    if np.abs(_run(model) - _run(paper_model(8e-3))).max() > 1e-12:
        yield "at its null values the model differs from the one without the effect"


def _felt(_: Effect, model: ContactModel) -> Iterator[str]:
    if np.abs(_run(model) - _run(paper_model(8e-3))).max() < 1e-6:
        yield "at its defaults nothing differs from the model without the effect"


def _seen(effect: Effect, model: ContactModel) -> Iterator[str]:
    present = _run(model)
    for p in effect.parameters:
        value = model.values[p.symbol].value
        step = 1e-3 * (value if p.transform == "log" else 1.0) * p.std
        other = model.with_value(p.symbol, value - step if value + step > p.high else value + step)
        if np.abs(_run(other) - present).max() < 1e-9:
            yield f"{p.symbol} moves no output: it cannot be learned from anything"


def _same_uncompiled(_: Effect, model: ContactModel) -> Iterator[str]:
    if not np.allclose(_run(model)[:300], _run(model, plain=True, samples=300), rtol=1e-9, atol=1e-12):
        yield "compiled and uncompiled code differ; look for integer division and for names bound later"


def _finite(effect: Effect, model: ContactModel) -> Iterator[str]:
    for bound in ("low", "high"):
        extreme = model
        try:
            for p in effect.parameters:
                extreme = extreme.with_value(p.symbol, getattr(p, bound))
            sound = bool(np.isfinite(_run(extreme)).all())
        except ModelError:
            sound = False
        if not sound:
            yield f"with all parameters at their {bound} bounds the result is not finite"


def _unchanged_by_reading(_: Effect, model: ContactModel) -> Iterator[str]:
    t, inputs = _motion(model)
    states, out, again = model.initial_states, np.empty((LAW_SAMPLES // 2, 7)), np.empty((1, 7))
    half = LAW_SAMPLES // 2
    run = model.compiled().run
    run(model.vector, states, t[:half], inputs[:half], out)
    kept = states.copy()
    run(model.vector, states, t[half - 1 : half], inputs[half - 1 : half], again)
    if not np.allclose(states, kept, rtol=1e-9, atol=1e-15) or not np.isclose(again[0, 2], out[-1, 2]):
        yield "reading the present state again (dt = 0) changes it; the online estimator would drift"


def _converges(_: Effect, model: ContactModel) -> Iterator[str]:
    """A quarter of the step at least halves the error; contact that begins within a step makes it uneven."""
    finest, fine, coarse = (_smooth_run(model, dt)[:: round(4e-3 / dt)] for dt in (2.5e-4, 1e-3, 4e-3))
    first, second = _error(coarse - finest), _error(fine - finest)
    if not (np.all(first <= 0.05) and np.all(second <= 0.5 * first + 1e-6)):
        yield "shorter steps do not lead to one result: use the exact solution over the step dt"


def _error(difference: Floats) -> Floats:
    """Return the rms of each column without the worst hundredth: instants that one of the steps misses."""
    size = np.sort(np.abs(difference), axis=0)[: -len(difference) // 100]
    rms: Floats = np.sqrt(np.mean(size**2, axis=0))
    return rms


def _smooth_run(model: ContactModel, dt: float) -> Floats:
    """Return all outputs over 3 s of a smooth motion through air and contact in steps of ``dt`` [s]."""
    t: Floats = dt * np.arange(round(3.0 / dt), dtype=float)
    x, K = model.reference_depth, model.values["K"].value
    delta = x * (0.7 - np.cos(4.4 * t) + 0.3 * np.sin(14.0 * t))
    load = 0.2 * K * (1.0 + np.sin(1.7 * t))
    return _outputs(model, t, _inputs(t, delta, load, x, 0.5 * x * (1.0 + np.sin(1.3 * t))))


def _run(model: ContactModel, *, plain: bool = False, samples: int = LAW_SAMPLES) -> Floats:
    """Return all outputs over the motion, shape (samples, 7), in units of order one."""
    t, inputs = _motion(model)
    return _outputs(model, t[:samples], inputs[:samples], plain=plain)


def _outputs(model: ContactModel, t: Floats, inputs: Floats, *, plain: bool = False) -> Floats:
    out = np.empty((len(t), 7))
    model.compiled(plain=plain).run(model.vector, model.initial_states, t, inputs, out)
    x, K = model.reference_depth, model.values["K"].value
    scale = np.array([x, K, K, K, np.sqrt(2.0 * model.tip_radius * x), 2.0, 1.0])
    scaled: Floats = out / scale
    return scaled


def _motion(model: ContactModel) -> tuple[Floats, Floats]:
    """Return times [s] and inputs: air, also between ramps, a hold, reversals, with a load that slips."""
    t: Floats = SAMPLE_PERIOD_S * np.arange(LAW_SAMPLES, dtype=float)
    x = model.reference_depth
    at = [0.0, 0.2, 0.3, 1.2, 1.5, 1.7, 2.0, 2.2, 2.6, 3.0]
    delta = x * np.interp(t, at, [-0.1, -0.1, 1.8, 1.8, -0.2, 2.2, 0.6, 1.0, 1.01, -0.3])
    load = model.values["K"].value * np.interp(t, [0.3, 2.0], [0.0, 0.8])
    return t, _inputs(t, delta, load, x, np.where(t > 2.0, x, 0.0))


def _inputs(t: Floats, delta: Floats, load: Floats, x: float, slip_speed: Floats) -> Floats:
    of = {
        "delta": delta,
        "speed": np.gradient(delta, t),
        "temperature": 23.0 + 4.0 * t,
        "tangential_force": load,
        "torque": 0.1 * load * x,
        "slip_speed": slip_speed,
        "tangential_force_x": load,
        "tangential_force_y": np.zeros_like(t),
    }
    return np.ascontiguousarray(np.stack([of[name] for name in INPUTS], axis=1))


LAWS: dict[str, Callable[[Effect, ContactModel], Iterator[str]]] = {
    "its parameters are declared soundly": _declared,
    "at its null values it is absent": _absent,
    "at its defaults it is felt": _felt,
    "every parameter moves some output": _seen,
    "compiled and uncompiled code agree": _same_uncompiled,
    "results are finite at the bounds of its parameters": _finite,
    "reading the present state changes nothing": _unchanged_by_reading,
    "shorter steps lead to one result": _converges,
}
"""What each law says, and the check that yields a sentence when it is broken."""
