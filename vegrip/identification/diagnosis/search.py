"""The search: screen, refit the best, judge, accept one, and again; then what is not needed is dropped.

Effects that are hidden together are found one after the other, each beside those that were accepted. An
effect that the accepted ones have made superfluous goes again.
"""

import math
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from vegrip.effects import Effect
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.acceptance import Verdict, judge_candidate, misfit_by_regime
from vegrip.identification.diagnosis.candidate_fit import (
    EVALUATIONS,
    CandidateFit,
    evaluate_candidate,
    extend_problem,
    finish_fit,
    held_out_groups,
    regime_map,
)
from vegrip.identification.diagnosis.catalogue import Candidate, candidates
from vegrip.identification.diagnosis.score_tests import Hint, carrier, screen_candidates
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import Optimum, Report, refine_optimum
from vegrip.types import Floats


@dataclass(frozen=True)
class EvidenceThreshold:
    """Nats that were gained so far and are left to be gained, the misfit by regime, and accepted effects.

    The first effect pays for being one of many, a further one for not being form: the law of an effect that
    was accepted need not have exactly the form of what is there. What it leaves invites further effects which
    only mend that form: they gain little of what was gained before, and little of what is left.
    """

    gained: float
    left: float
    misfit: float
    accepted: tuple[Effect, ...]

    def of(self, candidate: Effect) -> float:
        """Return what a candidate has to gain [nats]."""
        if not self.accepted:
            return thresholds.MIN_GAIN_NATS
        fits_noise = self.misfit <= thresholds.MAX_NOISE_CHI2
        share = thresholds.MIN_SHARE_OF_GAIN if fits_noise else thresholds.MIN_SHARE_OF_GAIN_IN_MISFIT
        least = thresholds.MIN_LATER_GAIN_NATS if fits_noise else thresholds.MIN_GAIN_NATS
        asked = max(least, share * self.gained)
        if self.left < thresholds.LITTLE_LEFT_SHARE * self.gained:
            asked = max(asked, thresholds.MIN_SHARE_OF_LEFT * self.left)
        if candidate.shifts_time and any(one.shifts_time for one in self.accepted):
            asked = max(asked, thresholds.MIN_TIMING_SHARE_OF_GAIN * self.gained)
        return asked


def required_evidence(
    first: CandidateFit, base: CandidateFit, misfit: float, accepted: Iterable[Effect]
) -> EvidenceThreshold:
    """Return what a further effect costs beside ``accepted`` ones, which led from ``first`` to ``base``."""
    return EvidenceThreshold(base.evidence - first.evidence, left(base), misfit, tuple(accepted))


def left(fitted: CandidateFit) -> float:
    """Return what is certainly more than noise in the sum of squares [nats]."""
    power = fitted.optimum.residual[fitted.problem.counted] ** 2
    by_chance = thresholds.SURELY_LEFT_STD * math.sqrt(0.5 * power.size)
    return max(0.5 * float(np.sum(power - 1.0)) - by_chance, 0.0)


@dataclass(frozen=True, eq=False)
class Tried:
    """A candidate that was refitted."""

    candidate: Candidate
    fitted: CandidateFit
    verdict: Verdict
    change: Floats  # of the whitened residual


@dataclass(eq=False)
class Step:
    """One round: what was there, what was tried, what was taken."""

    base: CandidateFit
    hints: list[Hint]
    tried: list[Tried]
    taken: Tried | None = None


@dataclass(eq=False)
class Search:
    """The whole search, with the last model."""

    steps: list[Step] = field(default_factory=list)
    out_of_sight: dict[str, str] = field(default_factory=dict)
    regimes: Floats = field(default_factory=lambda: np.zeros(0))
    dropped: list[str] = field(default_factory=list)

    @property
    def first(self) -> CandidateFit:
        return self.steps[0].base

    @property
    def last(self) -> CandidateFit:
        return self.steps[-1].base

    @property
    def accepted(self) -> list[Tried]:
        """What was taken, in order, and not dropped again."""
        taken = [step.taken for step in self.steps if step.taken is not None]
        return [one for one in taken if one.candidate.name not in self.dropped]

    @property
    def untaken(self) -> "Search":
        first = self.steps[0]
        return Search([Step(first.base, first.hints, first.tried)], self.out_of_sight, self.regimes)

    def misfit(self, fitted: CandidateFit) -> float:
        """Chi-square per regime; 1 is noise."""
        return misfit_by_regime(fitted.optimum.residual, self.regimes)


def search_effects(
    problem: Problem,
    optimum: Optimum,
    *,
    most: int = thresholds.MAX_NAMED_EFFECTS,
    threads: int = 2,
    report: Report = lambda _: None,
) -> Search:
    """Look for what ``problem``'s model lacks, from its optimum.

    What is best alone need not be part of what is best together: a second relaxation time imitates a power
    law and damping at once. Where several effects are named, or too few, the search is therefore made again
    from what came next, and the greatest evidence counts.
    """
    groups = held_out_groups(problem)
    base = evaluate_candidate(problem, optimum, groups)
    empty = Search(regimes=regime_map(problem, optimum.u))
    first = _step(base, groups, empty, threads, report)
    best = _grown(first, None, groups, empty, most, threads, report)
    for rival in rivals(best):
        report(f"begins with {rival.candidate.name}")
        other = _grown(first, rival, groups, empty, most, threads, report)
        if other.last.evidence > best.last.evidence + thresholds.MIN_GAIN_NATS:
            best = other
    return best


def rivals(found: Search) -> list[Tried]:
    """Return with what else a search might have begun, when it is worth while."""
    first, names = found.steps[0], {one.candidate.name for one in found.accepted}
    if first.taken is None or (len(names) < 2 and found.misfit(found.last) <= thresholds.MAX_NOISE_CHI2):
        return []
    least = thresholds.RIVAL_SHARE * first.taken.verdict.gain
    passed = [one for one in first.tried if one.verdict.is_passed and one.verdict.gain >= least]
    return [one for one in passed if one.candidate.name not in names][: thresholds.MAX_RIVALS]


def _grown(
    first: Step, choice: Tried | None, groups: Floats, empty: Search, most: int, threads: int, report: Report
) -> Search:
    """Take effects one after the other, the first of them the ``choice``, the best when not given."""
    found = Search([Step(first.base, first.hints, first.tried)], empty.out_of_sight, empty.regimes)
    while True:
        step = found.steps[-1]
        passed = [one for one in step.tried if one.verdict.is_passed]
        if not passed or len(found.accepted) >= most:
            break
        step.taken = choice or max(passed, key=lambda one: one.verdict.gain)
        choice = None
        report(f"takes {step.taken.candidate.name}")
        found.steps.append(_step(drop_unneeded(step.taken.fitted, groups), groups, found, threads, report))
    _drop_superfluous(found, groups)
    return found


def _step(base: CandidateFit, groups: Floats, found: Search, threads: int, report: Report) -> Step:
    model = base.problem.model
    if "K" in model.values:  # the scale of forces, which a saturation is measured by
        model = model.with_value("K", base.value("K"))
    possible, out_of_sight = candidates(model, base.problem.measured)
    found.out_of_sight = found.out_of_sight or out_of_sight
    report(f"screens {len(possible)} effects")
    hints = screen_candidates(base.problem, base.optimum, possible, threads)
    chosen = shortlist(hints)
    report("refits " + (", ".join(hint.candidate.name for hint in chosen) or "none"))
    misfit = found.misfit(base)
    first = found.steps[0].base if found.steps else base
    asked = required_evidence(first, base, misfit, [one.candidate.effect for one in found.accepted])

    def told(hint: Hint, new: CandidateFit) -> Tried:
        pays = asked.of(hint.candidate.effect)
        verdict = judge_candidate(hint.candidate, base, new, (misfit, found.misfit(new)), pays, asked.left)
        return Tried(hint.candidate, new, verdict, base.whitened(new) - base.optimum.residual)

    fits = _refitted(base, chosen, groups, threads)
    tried = [told(hint, new) for hint, new in zip(chosen, fits, strict=True)]
    return Step(base, hints, sorted(tried, key=lambda one: -one.verdict.gain))


def _refitted(base: CandidateFit, chosen: list[Hint], groups: Floats, threads: int) -> list[CandidateFit]:
    """Return the fits with each of the ``chosen``; only those that contend are made to the end."""
    with ThreadPoolExecutor(threads) as pool:
        fits = list(pool.map(lambda hint: extend_problem(base, hint, groups), chosen))
        gained = max((one.evidence - base.evidence for one in fits), default=0.0)
        least = base.evidence + thresholds.CONTENDER_SHARE * gained
        return list(
            pool.map(lambda one: finish_fit(base, one, groups) if one.evidence >= least else one, fits)
        )


def shortlist(hints: list[Hint]) -> list[Hint]:
    """Return the hints that are worth a refit."""
    if not hints:
        return []
    least = max(thresholds.MIN_GAIN_NATS, thresholds.MIN_SCREEN_SHARE * hints[0].gain)
    chosen = [hint for hint in hints if hint.gain >= least][: thresholds.MAX_REFITS]
    names = {hint.candidate.name for hint in chosen}
    others = [hint for hint in hints if hint.candidate.name not in names]
    kinked = [h for h in others if h.candidate.effect.kinked and h.gain >= 0.5 * least]
    mates = [h for h in others if names & set(h.candidate.effect.companions)]
    return chosen + kinked + mates


def drop_unneeded(fitted: CandidateFit, groups: Floats) -> CandidateFit:
    """Set up the noise anew at a fitted model, and fit it to the end."""
    problem = fitted.problem
    u = fitted.optimum.u
    problem.freeze(u)
    best = refine_optimum(problem, u, 2 * EVALUATIONS)
    return evaluate_candidate(problem, best, groups)


def _drop_superfluous(found: Search, groups: Floats) -> None:
    """Take each accepted effect but the last out again; it stays away if that costs too little."""
    for one in found.accepted[:-1]:
        last = found.last
        without = _without(last, one.candidate)
        rest = evaluate_candidate(
            without, refine_optimum(without, _shared(last, without), EVALUATIONS), groups
        )
        if last.evidence - rest.evidence < thresholds.MIN_GAIN_NATS:
            found.dropped.append(one.candidate.name)
            found.steps.append(Step(drop_unneeded(rest, groups), [], []))


def _without(fitted: CandidateFit, candidate: Candidate) -> Problem:
    """Return the problem with an effect held at nothing."""
    problem = fitted.problem
    model = problem.model
    own = {p.symbol for p in candidate.effect.parameters}
    for symbol in own:
        model = model.with_value(symbol, candidate.null[symbol])
    symbols = tuple(s for s in problem.symbols if s not in own)
    within = carrier(model, [])
    return Problem(model, problem.measured, zeros=problem.zeros, symbols=symbols, like=problem, within=within)


def _shared(fitted: CandidateFit, other: Problem) -> Floats:
    known = dict(zip(fitted.problem.unknowns.names, fitted.optimum.u, strict=True))
    return np.array([known[name] for name in other.unknowns.names])
