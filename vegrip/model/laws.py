"""What every effect must hold to, as a check that an author runs: ``broken_laws(EFFECT) == []``.

The catalogue's own tests (``tests/effects``) ask for more; these are the laws that a new effect breaks first.
"""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from vegrip.effects.contract import INPUTS, Effect
from vegrip.errors import ModelError
from vegrip.model import ContactModel, paper_model

Array = npt.NDArray[np.float64]

SAMPLES = 1500
PERIOD = 2e-3  # [s]


def broken_laws(effect: Effect) -> list[str]:
    """Return a sentence for each law that ``effect`` breaks on the model of the paper; none is good.

    It must be absent at its null values and felt at its defaults, every parameter must move some output,
    compiled and uncompiled code must agree, results must be finite at all bounds of the parameters, and a
    reading of the present state (``dt = 0``) must change nothing.
    """
    try:
        model = paper_model(8e-3).with_effect(effect)
        model.compiled()
    except ModelError as error:
        return [str(error)]
    laws = (_declared, _absent, _felt, _seen, _same_uncompiled, _finite, _unchanged_by_reading)
    return [sentence for law in laws for sentence in law(effect, model)]


def _declared(effect: Effect, _: ContactModel) -> Iterator[str]:
    if not any(p.null is not None for p in effect.parameters):
        yield "no parameter has a null value: nobody could test whether the effect is there"
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
    states, out, again = model.initial_states, np.empty((SAMPLES // 2, 7)), np.empty((1, 7))
    half = SAMPLES // 2
    run = model.compiled().run
    run(model.vector, states, t[:half], inputs[:half], out)
    kept = states.copy()
    run(model.vector, states, t[half - 1 : half], inputs[half - 1 : half], again)
    if not np.allclose(states, kept, rtol=1e-9, atol=1e-15) or not np.isclose(again[0, 2], out[-1, 2]):
        yield "reading the present state again (dt = 0) changes it; the online estimator would drift"


def _run(model: ContactModel, *, plain: bool = False, samples: int = SAMPLES) -> Array:
    """Return all outputs over the motion, shape (samples, 7), in units of order one."""
    t, inputs = _motion(model)
    out = np.empty((samples, 7))
    run = model.compiled(plain=plain).run
    run(model.vector, model.initial_states, t[:samples], inputs[:samples], out)
    x, K = model.reference_depth, model.values["K"].value
    scale = np.array([x, K, K, K, np.sqrt(2.0 * model.tip_radius * x), 2.0, 1.0])
    scaled: Array = out / scale
    return scaled


def _motion(model: ContactModel) -> tuple[Array, Array]:
    """Return times [s] and inputs: air, ramps of two speeds, a hold, reversals, with a load that slips."""
    t: Array = PERIOD * np.arange(SAMPLES, dtype=float)
    x = model.reference_depth
    at = [0.0, 0.2, 0.3, 1.2, 1.5, 1.7, 2.0, 2.2, 2.6, 3.0]
    delta = x * np.interp(t, at, [-0.1, -0.1, 1.8, 1.8, 0.3, 2.2, 0.6, 1.0, 1.01, -0.3])
    load = model.values["K"].value * np.interp(t, [0.3, 2.0], [0.0, 0.8])
    of = {
        "delta": delta,
        "speed": np.gradient(delta, t),
        "temperature": 23.0 + 4.0 * t,
        "tangential_force": load,
        "torque": 0.1 * load * x,
        "slip_speed": np.where(t > 2.0, x, 0.0),
        "tangential_force_x": load,
        "tangential_force_y": np.zeros_like(t),
    }
    return t, np.ascontiguousarray(np.stack([of[name] for name in INPUTS], axis=1))
