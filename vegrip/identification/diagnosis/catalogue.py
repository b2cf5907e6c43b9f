"""The candidates: effects that a model does not have and a recording could show, and where to look for each.

An effect is absent at the null values of its parameters. It is tried with one of those parameters at its
declared value and the others absent, over a few values of what only shapes it (rates, lengths).
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from vegrip.effects import BUILT_IN, Effect, effect, names
from vegrip.errors import ModelError
from vegrip.identification.fit.preprocess import Measured
from vegrip.identification.fit.whitening import arguments_of
from vegrip.model import BASE, ContactModel
from vegrip.model.composer import share_a_name
from vegrip.parameters import Parameter

SPREADS = {1: (-3.0, -1.5, 0.0, 1.5, 3.0), 2: (-2.0, 0.0, 2.0)}
"""Prior standard deviations at which one shape is tried, or each of two."""

MIN_TEMPERATURE_SCATTER_K = 0.3  # [K] of scatter below which a temperature tells nothing

FRICTION_CHANNELS = {"tangential_force", "torque_z"}

Trial = Mapping[str, float]


@dataclass(frozen=True)
class Candidate:
    """An effect and the values at which it is tried."""

    effect: Effect
    null: Trial  # absent
    trials: tuple[Trial, ...]

    @property
    def name(self) -> str:
        return self.effect.name


def candidates(model: ContactModel, measured: Measured) -> tuple[list[Candidate], dict[str, str]]:
    """Return what could be added to ``model``, and the effects that cannot show, each with the reason."""
    present = {e.name for e in model.effects}
    foreign = [e for e in model.effects if e.name not in BUILT_IN]
    found, out_of_sight = [], {}
    for name in names():
        if name in BASE or name in present:
            continue
        one = effect(name)
        reason = why_unseen(one, measured)
        if not reason and (name not in BUILT_IN or any(share_a_name(one, e) for e in foreign)):
            reason = _unfit(model, one)
        if reason:
            out_of_sight[name] = reason
        else:
            tried = [*trials(one), *trials_in(one, model, measured)]
            found.append(Candidate(one, null(one), tuple(tried)))
    return found, out_of_sight


def _unfit(model: ContactModel, one: Effect) -> str:
    """Return why another package's effect does not go with the model."""
    try:
        model.with_effect(one)
    except ModelError as error:
        return str(error)
    return ""


def why_unseen(one: Effect, measured: Measured) -> str:
    """Return why the recording cannot show an effect, empty where it can."""
    columns = measured.recording.columns
    takes = {name for hook in one.hooks for name in arguments_of(hook.function)}
    if "temperature" in takes:
        if "temperature" not in columns:
            return "no temperature was recorded"
        if np.nanstd(columns["temperature"]) < MIN_TEMPERATURE_SCATTER_K:
            return "the temperature hardly changed"
    tangential = {"tangential_force", "tangential_force_x", "tangential_force_y"} & takes
    if tangential and not {"tangential_force_x", "tangential_force_y"} & set(columns):
        return "no tangential force was recorded"
    can = {"normal_force"}
    if measured.sliding.size:
        can |= FRICTION_CHANNELS
    if measured.seen.size:
        can.add("contact_radius")
    if not can & set(one.channels):
        return (
            "it shows only in slip"
            if set(one.channels) <= FRICTION_CHANNELS
            else "it shows only in the radius"
        )
    return ""


def null(one: Effect) -> dict[str, float]:
    """Return the values at which the effect is absent; shapes as declared."""
    return {p.symbol: p.default if p.null is None else p.null for p in one.parameters}


def trials(one: Effect) -> Iterator[dict[str, float]]:
    """Yield the values at which to look for the effect."""
    amounts = [p for p in one.parameters if p.null is not None]
    shapes = [p for p in one.parameters if p.null is None]
    for amount in amounts:
        kept = [p for p in shapes if p.transform == "log"][:2] or shapes[:1]
        spreads = SPREADS.get(len(kept), (0.0,))
        shaped = dict(one.trial_shapes)
        places = [shaped.get(p.symbol) or [moved(p, z) for z in spreads] for p in kept]
        for at in itertools.product(*places):
            for size in one.trial_sizes:
                values = null(one)
                values[amount.symbol] = min(size * _amount(amount), amount.high)
                yield values | dict(zip([p.symbol for p in kept], at, strict=True))


def trials_in(one: Effect, model: ContactModel, measured: Measured) -> Iterator[Trial]:
    """Yield the values at which to look for the effect in this recording besides."""
    if one.trials_at is not None:
        values = {symbol: value.value for symbol, value in model.values.items()}
        yield from one.trials_at(values, float(np.nanmax(np.abs(measured.force))))


def _amount(p: Parameter) -> float:
    if p.default != p.null:
        return p.default
    return min((p.null or 0.0) + p.std, p.high)


def moved(p: Parameter, z: float) -> float:
    """Return the value ``z`` prior standard deviations from the default, within the bounds."""
    value = p.default * math.exp(z * p.std) if p.transform == "log" else p.default + z * p.std
    return min(max(value, p.low), p.high)
