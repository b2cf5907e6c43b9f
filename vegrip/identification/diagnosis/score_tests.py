"""The screen: one evaluation for each trial of each candidate, no fit.

With residual w, derivatives J of the model that is there, and the change s that a candidate at its declared
size makes, the best multiple of s beside a refit of everything else leaves
``|w|^2 / 2 - gain``,   ``gain = (p . w)^2 / (2 (p . p + q))``,   p = s without what J can imitate,
q what the prior asks for a multiple of one: a score test [Rao1948]_ that costs one run of the model. All
candidates live in one compiled model, absent but for the one on trial.
"""

import dataclasses
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from vegrip.effects import BUILT_IN, effect, place
from vegrip.errors import ModelError
from vegrip.identification.diagnosis.catalogue import Candidate, Trial, null
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import Optimum
from vegrip.model import ContactModel
from vegrip.model.composer import share_a_name
from vegrip.parameters import changed, coordinate, declared
from vegrip.types import Floats

MIN_SIGNATURE_SHARE = 1e-12  # of a signature's power that must be left beside the model


@dataclass(frozen=True, eq=False)
class Hint:
    """The screen's answer for one candidate: gain [nats], trial, and the best multiple of its amount."""

    candidate: Candidate
    gain: float
    trial: Trial
    multiple: float
    visible: float  # share of the signature's power that the model cannot imitate
    signature: Floats  # visible part, unit length


def screen_candidates(
    problem: Problem, optimum: Optimum, candidates: Sequence[Candidate], threads: int = 2
) -> list[Hint]:
    """Return a hint for every candidate that changes anything, best first."""
    std = problem.unknowns.std
    basis, _ = np.linalg.qr(np.vstack([optimum.jacobian, np.diag(1.0 / std)]))
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
        return Hint(
            candidate, gain, trial, multiple, left / power, (p / math.sqrt(left))[:rows].astype(np.float32)
        )

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
    return Problem(p.model, p.measured, zeros=p.zeros, symbols=p.symbols, like=p, within=within)


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
