"""The screen: one evaluation for each trial of each candidate, no fit.

With residual w, derivatives J of the model that is there, and the change s that a candidate at its declared
size makes, the best multiple of s beside a refit of everything else leaves
``|w|^2 / 2 - gain``,   ``gain = (p . w)^2 / (2 (p . p + q))``,   p = s without what J can imitate,
q what the prior asks for a multiple of one: a score test [Rao1948]_ that costs one run of the model. All
candidates live in one compiled model, absent but for the one on trial.
"""

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from vegrip.effects import BUILT_IN, Effect, effect, names, place
from vegrip.errors import ModelError
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.fit.noise import LEAST_AIR, at_rest, in_air
from vegrip.identification.fit.preprocess import Measured
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import Optimum
from vegrip.identification.fit.whitening import arguments_of
from vegrip.model import BASE, ContactModel
from vegrip.model.composer import share_a_name
from vegrip.parameters import Parameter, changed, coordinate, declared
from vegrip.types import Floats

SPREADS = {1: (-3.0, -1.5, 0.0, 1.5, 3.0), 2: (-2.0, 0.0, 2.0)}
"""Prior standard deviations at which one shape is tried, or each of two."""

MIN_TEMPERATURE_SCATTER_K = 0.3  # [K] of scatter below which a temperature shows nothing

OF_DEPTH = {"x", "contact_radius", "reference_depth"}
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
    """Return what could be added to ``model``, and the effects that cannot show, each with the reason.

    Not what is tried in the place of another one, see :func:`generals`.
    """
    present = {e.name for e in model.effects}
    foreign = [e for e in model.effects if e.name not in BUILT_IN]
    found, out_of_sight = [], {}
    for name in names():
        one = effect(name)
        if name in BASE or name in present or one.generalises:
            continue
        reason = why_unseen(one, measured)
        if measured.recording.is_step and not is_of_material(one):
            reason = "a step without a contact shows stiffness and memory alone"
        if not reason and (name not in BUILT_IN or any(share_a_name(one, e) for e in foreign)):
            reason = _unfit(model, one)
        if reason:
            out_of_sight[name] = reason
        else:
            found.append(candidate_of(one, model, measured))
    return found, out_of_sight


def generals(model: ContactModel, measured: Measured) -> list[Candidate]:
    """Return what effects of ``model`` may be cases of, as candidates for their place."""
    present = {one.name for one in model.effects}
    every = [one for one in map(effect, names()) if one.name not in present and not why_unseen(one, measured)]
    return [candidate_of(one, model, measured) for one in every if present & set(one.generalises)]


def candidate_of(one: Effect, model: ContactModel, measured: Measured) -> Candidate:
    return Candidate(one, null(one), (*trials(one), *trials_in(one, model, measured)))


def _unfit(model: ContactModel, one: Effect) -> str:
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
    if one.in_air and not moves_in_air(measured):
        return "the drive hardly moves in the air"
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


def is_of_material(one: Effect) -> bool:
    """Whether it is memory, or of its rates, and knows no depth."""
    takes = {name for hook in one.hooks for name in arguments_of(hook.function)}
    return "relaxation_rate" in takes and not takes & OF_DEPTH


def moves_in_air(measured: Measured) -> bool:
    """Whether enough rows are of motion without a contact."""
    air = in_air(measured.recording)
    rest = at_rest(measured.recording, air, measured.noise.displacement)
    return int(np.count_nonzero(air & ~rest)) >= LEAST_AIR


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
    value = p.default * math.exp(z * p.std) if p.transform == "log" else p.default + z * p.std
    return min(max(value, p.low), p.high)


MIN_SIGNATURE_SHARE = 1e-12  # of a signature's power that must be left beside the model


@dataclass(frozen=True, eq=False)
class Hint:
    """The screen's answer for one candidate: gain [nats], trial, and the best multiple of its amount."""

    candidate: Candidate
    gain: float
    trial: Trial
    multiple: float
    signature: Floats  # what the model cannot imitate, unit length


def screen_candidates(
    problem: Problem, optimum: Optimum, candidates: Sequence[Candidate], threads: int = 2
) -> list[Hint]:
    """Return a hint for every candidate that changes anything, best first."""
    k = problem.unknowns
    span = thresholds.AT_BOUND_STD * k.std
    free = (optimum.u - k.low > span) & (k.high - optimum.u > span)  # beyond its bound nothing can imitate
    basis, _ = np.linalg.qr(np.vstack([optimum.jacobian, np.diag(1.0 / k.std)])[:, free])
    rows = optimum.residual.size
    padded = np.zeros(basis.shape[0])
    padded[:rows] = optimum.residual
    jobs = [
        (group, c, trial) for group in _groups(problem, candidates) for c in group[1] for trial in c.trials
    ]

    def screen(job: tuple[tuple[Problem, list[Candidate]], Candidate, Trial]) -> Hint | None:
        (wide, _), candidate, trial = job
        s = np.zeros(basis.shape[0])
        s[:rows] = wide.white(wide.raw(wide.table(optimum.u, trial))) - optimum.residual
        power = float(s @ s)
        if not 0.0 < power < math.inf:
            return None
        p = s - basis @ (basis.T @ s)
        left = float(p @ p)
        if left < MIN_SIGNATURE_SHARE * power or left <= 0.0:
            return None
        along = float(p @ padded)
        firm = left + _prior(candidate, trial)
        multiple = -along / firm
        gain = 0.5 * along * along / firm if _is_allowed(candidate, trial, multiple) else 0.0
        return Hint(candidate, gain, trial, multiple, (p / math.sqrt(left))[:rows].astype(np.float32))

    best: dict[str, Hint] = {}
    with ThreadPoolExecutor(threads) as pool:
        for hint in pool.map(screen, jobs):
            if hint is not None and (
                hint.candidate.name not in best or hint.gain > best[hint.candidate.name].gain
            ):
                best[hint.candidate.name] = hint
    return sorted(best.values(), key=lambda hint: -hint.gain)


def _groups(problem: Problem, candidates: Sequence[Candidate]) -> list[tuple[Problem, list[Candidate]]]:
    """Put candidates into few models: one for all but the dear ones, which stand alone.

    So does an effect of another package that has a name in common with one that is built in.
    """
    ours = [effect(name) for name in BUILT_IN]

    def stands_alone(one: Candidate) -> bool:
        is_foreign = one.name not in BUILT_IN
        return one.effect.expensive or (is_foreign and any(share_a_name(one.effect, other) for other in ours))

    alone = [[c] for c in candidates if stands_alone(c)]
    together = [c for c in candidates if not stands_alone(c)]
    try:
        groups = [group for group in (together, *alone) if group]
        return [(widened(problem, group), group) for group in groups]
    except ModelError:  # effects that do not go with each other
        return [(widened(problem, [c]), [c]) for c in candidates]


def widened(problem: Problem, candidates: list[Candidate]) -> Problem:
    """Return the problem, run by a model in which the candidates are, absent; noise and rows are kept."""
    p = problem
    within = carrier(p.model, candidates)
    return Problem(p.model, p.measured, symbols=p.symbols, like=p, within=within)


def carrier(model: ContactModel, candidates: Sequence[Candidate]) -> ContactModel:
    """Return a model with the candidates, absent, and unless it is dear with every effect that is built in.

    The same whatever can be seen and whatever was accepted, because to compile it takes ten seconds; but for
    an effect of another package that has a name in common with one that is built in.
    """
    there = [*model.effects, *(one.effect for one in candidates)]
    present = {one.name for one in there}
    more = (
        []
        if any(one.effect.expensive for one in candidates)
        else [n for n in BUILT_IN if n not in present and not effect(n).expensive]
    )
    is_foreign = [one for one in there if one.name not in BUILT_IN]
    beside = [e for e in map(effect, more) if not any(share_a_name(e, other) for other in is_foreign)]
    return with_candidates(model, [*candidates, *(Candidate(e, null(e), ()) for e in beside)])


def with_candidates(model: ContactModel, candidates: Sequence[Candidate]) -> ContactModel:
    """Return the model with effects added, absent."""
    effects, values = list(model.effects), dict(model.values)
    for one in candidates:
        effects.insert(place([e.name for e in effects], one.name), one.effect)
        for p in one.effect.parameters:
            values[p.symbol] = changed(declared(p), value=one.null[p.symbol])
    return dataclasses.replace(model, effects=tuple(effects), values=values)  # once: every model is tried out


def _prior(candidate: Candidate, trial: Trial) -> float:
    total = 0.0
    for p in candidate.effect.parameters:
        if p.null is not None and trial[p.symbol] != p.null:
            total += ((coordinate(p, trial[p.symbol]) - coordinate(p, p.null)) / p.std) ** 2
    return total


def _is_allowed(candidate: Candidate, trial: Trial, multiple: float) -> bool:
    for p in candidate.effect.parameters:
        if p.null is not None and trial[p.symbol] != p.null:
            value = p.null + multiple * (trial[p.symbol] - p.null)
            if not p.low <= value:
                return False
            if not value <= p.high:
                return multiple > 0.0
    return True
