"""The search: screen, refit the best, judge, accept one, and again; and each has to hold its place.

Effects that are hidden together are found one after the other, each beside those that were accepted. What is
best beside few need not be best beside all: whatever resembles an accepted effect is refitted in its place,
and takes it where it is better. An effect that the others have made superfluous goes again.
"""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from vegrip.effects import Effect, effect, names
from vegrip.host.memory import give_back_memory
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.acceptance import (
    Verdict,
    form_directions,
    judge_candidate,
    misfit_by_regime,
)
from vegrip.identification.diagnosis.candidate_fit import (
    EVALUATIONS,
    CandidateFit,
    compiled_already,
    evaluate_candidate,
    extend_below,
    extend_problem,
    finish_fit,
    held_out_groups,
    regime_map,
)
from vegrip.identification.diagnosis.score_tests import (
    Candidate,
    Hint,
    candidates,
    generals,
    screen_candidates,
)
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import Optimum, Report, refine_optimum
from vegrip.types import Floats


@dataclass(frozen=True)
class EvidenceThreshold:
    """Nats that were gained so far and are left to be gained, the misfit by regime, and accepted effects.

    The first effect pays for being one of many, a further one for not being form: the law of an effect that
    was accepted need not have exactly the form of what is there. What it leaves invites further effects which
    only mend that form: they gain little of what was gained before, and little of what is left. They mend it
    in the channels in which it was gained, and leave some of it.
    """

    gained: float
    share: Floats  # (rows,) of it that was gained in the channel of each
    left: float
    misfit: float
    accepted: tuple[Effect, ...]

    def of(self, candidate: Effect, change: Floats, *, is_exact: bool) -> float:
        """Return what a candidate has to gain [nats].

        ``change`` (rows,): what it makes of the residual; ``is_exact``: it leaves noise alone.
        """
        if not self.accepted:
            return thresholds.MIN_GAIN_NATS
        fits_noise = self.misfit <= thresholds.MAX_NOISE_CHI2
        share = thresholds.MIN_SHARE_OF_GAIN if fits_noise else thresholds.MIN_SHARE_OF_GAIN_IN_MISFIT
        least = thresholds.MIN_LATER_GAIN_NATS if fits_noise else thresholds.MIN_GAIN_NATS
        asked = max(least, share * self.gained)
        if is_exact:
            power = change**2
            share *= float(np.sum(self.share * power)) / max(float(np.sum(power)), 1e-300)
            share = share if fits_noise else min(share, thresholds.MIN_SHARE_OF_GAIN_TO_NOISE)
            asked = min(asked, max(thresholds.MIN_LATER_GAIN_NATS, share * self.gained))
        if self.left < thresholds.LITTLE_LEFT_SHARE * self.gained:
            asked = max(asked, thresholds.MIN_SHARE_OF_LEFT * self.left)
        if any(are_kin(candidate, one) and not have_general(candidate, one) for one in self.accepted):
            asked = max(asked, thresholds.MIN_KIN_SHARE_OF_GAIN * self.gained)
        return asked

    def at_least(self, candidate: Effect) -> float:
        """Return what a candidate has to gain [nats] whatever it makes of the residual.

        What leaves noise alone pays less, but has gained what is left.
        """
        nothing = np.zeros(self.share.size)
        leaving, exact = (self.of(candidate, nothing, is_exact=one) for one in (False, True))
        least = min(leaving, max(exact, thresholds.SURELY_GAINED_SHARE * self.left))
        return max(least, candidate.min_gain)


def required_evidence(
    first: CandidateFit, base: CandidateFit, misfit: float, accepted: Iterable[Effect]
) -> EvidenceThreshold:
    """Return what a further effect costs beside ``accepted`` ones, which led from ``first`` to ``base``."""
    p, before, after = base.problem, base.whitened(first), base.optimum.residual
    taken = np.where(p.counted, before**2 - after**2, 0.0)
    channel = np.repeat(np.arange(3), [p.doubtful.size, p.slip_std.size, p.radius_std.size])
    by_channel = np.maximum(np.bincount(channel, taken, 3), 0.0)
    share = by_channel / max(float(by_channel.sum()), 1e-300)
    return EvidenceThreshold(
        base.evidence - first.evidence, share[channel], left(base), misfit, tuple(accepted)
    )


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
    # accepted effect -> the last model without it, and what was refitted in its place, itself the first
    contests: dict[str, Step] = field(default_factory=dict)
    # an effect that explains as much as all of these, which are cases of it
    general: dict[str, list[str]] = field(default_factory=dict)
    is_given_up: bool = False
    is_stopped: bool = False  # by an interrupt, before its end
    # in the last round: evidence [nats] and error of each
    refitted: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def first(self) -> CandidateFit:
        return self.steps[0].base

    @property
    def last(self) -> CandidateFit:
        return self.steps[-1].base

    @property
    def accepted(self) -> list[Tried]:
        taken = [step.taken for step in self.steps if step.taken is not None]
        return [one for one in taken if one.candidate.name not in self.dropped]

    @property
    def untaken(self) -> "Search":
        first = self.steps[0]
        return Search([Step(first.base, first.hints, first.tried)], self.out_of_sight, self.regimes)

    def leaves_too_much(self, more: float) -> bool:
        """Whether the last model leaves more than is named even if effects gain so much ``more`` [nats]."""
        noise = 0.5 * int(np.count_nonzero(self.last.problem.counted))
        return left(self.last) - more > (thresholds.MAX_ERROR**2 - 1.0) * noise

    @property
    def is_patchwork(self) -> bool:
        """Whether more effects than are believed leave what no noise does: no exchange makes them right."""
        count, misfit = len(self.accepted), self.misfit(self.last)
        return count > thresholds.PATCHWORK_EFFECTS and misfit > thresholds.MAX_NOISE_CHI2

    @property
    def is_within_tolerance(self) -> bool:
        """Whether one effect more would make a patchwork of what is as exact as was asked already."""
        is_last = len(self.accepted) == thresholds.PATCHWORK_EFFECTS - 1
        return is_last and self.last.error < 1.0 and self.last.problem.measured.noise.tolerance > 0.0

    @property
    def is_rough(self) -> bool:
        """Whether the forms of the laws leave more than noise."""
        misfit, error = self.misfit(self.last), self.last.error
        return misfit > thresholds.MAX_NOISE_CHI2 or error > thresholds.MAX_EXACT_ERROR

    def within(self, gain: float) -> float:
        """Return by how much [nats] two that gain about so much may differ and not be distinguished."""
        share = thresholds.ROUGH_SHARE if self.is_rough else thresholds.INDISTINGUISHABLE_SHARE
        return max(thresholds.INDISTINGUISHABLE_NATS, share * gain)

    def misfit(self, fitted: CandidateFit) -> float:
        """Chi-square per regime; 1 is noise."""
        return misfit_by_regime(fitted.optimum.residual, self.regimes)

    def leaves_noise(self, fitted: CandidateFit) -> bool:
        """Whether nothing stands out any more, in a regime or in all."""
        return self.misfit(fitted) <= thresholds.MAX_NOISE_CHI2 and not left(fitted)


def search_effects(
    problem: Problem,
    optimum: Optimum,
    *,
    most: int = thresholds.MAX_NAMED_EFFECTS,
    threads: int = 2,
    report: Report = lambda _: None,
    is_repeat: bool = False,
    can_stop: bool = False,
) -> Search:
    """Look for what ``problem``'s model lacks, from its optimum.

    ``is_repeat``: the answer counts only if it explains the recording, and is given up when it cannot.
    ``can_stop``: an interrupt gives what was found until then.
    """
    groups = held_out_groups(problem)
    found = Search(regimes=regime_map(problem, optimum.u))
    found.steps = [Step(evaluate_candidate(problem, optimum, groups), [], [])]
    try:
        _search(found, groups, most, threads, report, is_repeat=is_repeat)
    except KeyboardInterrupt:
        if not can_stop:
            raise
        found.is_stopped = True
    return found


def _search(
    found: Search, groups: Floats, most: int, threads: int, report: Report, *, is_repeat: bool
) -> None:
    found.steps = [_step(found.first, groups, found, threads, report)]
    while True:
        step = found.steps[-1]
        passed = [one for one in step.tried if one.verdict.is_passed]
        is_taking = bool(passed) and len(found.accepted) < most and not found.is_within_tolerance
        is_done = not is_taking and (found.contests or not found.accepted or found.is_patchwork)
        if is_done and not take_general(found, groups, threads, report):
            return
        if is_taking:
            step.taken = max(passed, key=lambda one: one.verdict.gain)
            report(f"takes {step.taken.candidate.name}")
            found.steps.append(Step(drop_unneeded(step.taken.fitted, groups), [], []))
            found.contests = {}
        # none gains more beside the others than the best of this round
        more = max(thresholds.PATCHWORK_EFFECTS - len(found.accepted), 0) if is_taking else 0
        best = max((one.verdict.gain for one in step.tried), default=0.0)
        found.is_given_up = is_repeat and found.leaves_too_much(more * best)
        if found.is_given_up:
            return
        # the rivals of the first effect were refitted in its place just now
        if (not is_taking or len(found.accepted) > 1) and not found.is_patchwork:
            hold_contests(found, groups, threads, report)
        if not found.steps[-1].hints:
            found.steps[-1] = _step(found.last, groups, found, threads, report)


def hold_contests(found: Search, groups: Floats, threads: int, report: Report) -> None:
    """Let what resembles each accepted effect contest its place, until none takes it."""
    for _ in range(thresholds.MAX_EXCHANGES):
        found.contests = {}
        for one in found.accepted:
            contest = contest_place(found, one, groups, threads)
            name, own, better = one.candidate.name, contest.tried[0], contest.taken
            is_needed = own.verdict.gain >= thresholds.MIN_GAIN_NATS or len(found.accepted) == 1
            if better is own and is_needed:
                found.contests[name] = contest
                continue
            report(f"drops {name}")
            found.dropped.append(name)
            next_model = contest.base
            if better is not None and better is not own:
                found.steps[-1], next_model = contest, better.fitted
            found.steps.append(Step(drop_unneeded(next_model, groups), [], []))
            break
        else:
            return


def contest_place(found: Search, one: Tried, groups: Floats, threads: int) -> Step:
    """Refit what resembles ``one`` in its place; return all that was tried, ``one`` first, and the better.

    Each from the optimum without it, and where it is not far behind from the values that the others have
    beside it, where the rival has to make up for what it explains. What is known to be confounded is refitted
    whatever the screen expects of it, for that knows a kink only at the depths that it tries. What stays so
    far behind that it neither wins nor stands beside ``one`` is given up.
    """
    step = next(step for step in found.steps if step.taken is one)
    fits: dict[str, CandidateFit] = {}
    if len(found.accepted) == 1 and step.base is found.first:  # what was tried was tried in its place
        rest, last, hints = step.base, one.fitted, step.hints
        fits = {each.candidate.name: each.fitted for each in step.tried}
    else:
        last, problem = found.last, _without(found.last, one.candidate)
        rest = evaluate_candidate(
            problem, refine_optimum(problem, _shared(last, problem), EVALUATIONS), groups
        )
        seen = {h.candidate.name for s in found.steps for h in s.hints if h.gain >= thresholds.MIN_GAIN_NATS}
        seen = seen - {each.candidate.name for each in found.accepted} | {one.candidate.name}
        every = candidates(problem.model, problem.measured)[0]
        possible = [c for c in every if c.name in seen or are_kin(c.effect, one.candidate.effect)]
        hints = screen_candidates(problem, rest.optimum, possible, threads)
    gain, dropped = last.evidence - rest.evidence, found.dropped  # what was dropped stays away
    hints = resembling(one.candidate, gain, [h for h in hints if h.candidate.name not in dropped])

    # farther behind it neither wins nor stands beside
    behind = max(found.within(gain), thresholds.FORM_NATS)
    worst = rest.optimum.cost - (gain - behind)

    def refit(start: CandidateFit, some: list[Hint]) -> None:
        def better(hint: Hint) -> CandidateFit | None:
            before = fits.get(hint.candidate.name)
            is_alike = before is not None and before.problem.whitener is rest.problem.whitener
            least = min(worst, before.optimum.cost) if before is not None and is_alike else worst
            return extend_below(start, hint, groups, least)

        with ThreadPoolExecutor(threads) as pool:
            for hint, new in zip(some, pool.map(better, some), strict=True):
                if new is not None:
                    best = fits.get(hint.candidate.name, new)
                    fits[hint.candidate.name] = max(best, new, key=lambda each: each.evidence)

    passed_screen = [hint for hint in hints if hint.gain >= thresholds.MIN_GAIN_NATS]
    refit(rest, [hint for hint in passed_screen if hint.candidate.name not in fits])
    least = rest.evidence + thresholds.SECOND_START_SHARE * gain
    near = [
        hint.candidate
        for hint in hints
        if are_kin(hint.candidate.effect, one.candidate.effect)
        or hint.candidate.name not in fits
        or fits[hint.candidate.name].evidence >= least
    ]
    nulled = _at(rest, _shared(last, rest.problem))
    second = screen_candidates(rest.problem, nulled.optimum, near, threads)
    refit(nulled, second)
    hints = [hint for hint in hints if hint.candidate.name in fits]
    misfit = found.misfit(rest)

    def tried_of(candidate: Candidate, new: CandidateFit) -> Tried:
        verdict = judge_candidate(candidate, rest, new, (misfit, found.misfit(new)), left=left(rest))
        change = rest.whitened(new) - rest.optimum.residual
        return Tried(candidate, new.without_derivatives(), verdict, change)

    own = tried_of(one.candidate, last)
    rivals = [tried_of(hint.candidate, fits[hint.candidate.name]) for hint in hints]
    rivals.sort(key=lambda each: -each.verdict.gain)
    passed = [each for each in rivals if each.verdict.is_passed]
    wins = bool(passed) and passed[0].verdict.gain > own.verdict.gain + found.within(own.verdict.gain)
    return Step(rest, hints, [own, *rivals], passed[0] if wins else own)


def take_general(found: Search, groups: Floats, threads: int, report: Report) -> bool:
    """Put what holds accepted effects as cases in their place, where it explains more; return whether it did.

    Where one of them alone leaves no more than noise it has to show its form, and a tolerance shows none.
    """
    last = found.last
    is_exact = not (found.is_rough and last.error > 1.0)
    for general in generals(last.problem.model, last.problem.measured):
        kin = [one for one in found.accepted if one.candidate.name in general.effect.generalises]
        names = [one.candidate.name for one in kin]
        is_enough = len(kin) == 1 and is_exact
        if not kin or (is_enough and last.problem.measured.noise.tolerance > 0.0):
            continue
        report(f"refits {general.name} for {', '.join(names)}")
        problem = _without(last, *(one.candidate for one in kin))
        rest = evaluate_candidate(
            problem, refine_optimum(problem, _shared(last, problem), EVALUATIONS), groups
        )
        hints = screen_candidates(problem, rest.optimum, [general], threads)
        misfit, gain = found.misfit(rest), last.evidence - rest.evidence
        more = max(found.within(gain), thresholds.FORM_NATS if is_enough else 0.0)
        asked = gain + more if len(kin) == 1 else gain - found.within(gain)
        for hint in hints:
            new = extend_below(rest, hint, groups, rest.optimum.cost - asked)
            if new is None:
                continue
            verdict = judge_candidate(general, rest, new, (misfit, found.misfit(new)), left=left(rest))
            if not verdict.is_passed:
                continue
            if verdict.gain > gain + more:
                report(f"takes {general.name}")
                taken = Tried(general, new, verdict, rest.whitened(new) - rest.optimum.residual)
                found.steps[-1] = Step(rest, hints, [taken], taken)
                found.steps.append(Step(drop_unneeded(new, groups), [], []))
                found.dropped += names
                return True
            if len(kin) > 1 and verdict.gain >= gain - found.within(gain):
                found.general[general.name] = names
    return False


def _at(fitted: CandidateFit, u: Floats) -> CandidateFit:
    problem, k = fitted.problem, fitted.problem.unknowns
    r = problem.residual(u)
    cost = 0.5 * float(r @ r + np.sum(((u - k.prior) / k.std) ** 2))
    return dataclasses.replace(fitted, optimum=Optimum(u, r, problem.jacobian(u, r), cost))


def are_kin(one: Effect, other: Effect) -> bool:
    """Whether two effects are known to resemble each other."""

    def names(of: Effect, another: Effect) -> bool:
        return another.name in (*of.companions, *of.confounded)

    is_group = bool(one.group) and one.group == other.group
    is_shift = one.shifts_time and other.shifts_time
    return one.name != other.name and (is_group or is_shift or names(one, other) or names(other, one))


def have_general(one: Effect, other: Effect) -> bool:
    """Whether an effect holds both as cases, which judges whether it is one law of another form."""
    return any({one.name, other.name} <= set(effect(name).generalises) for name in names())


def resembling(own: Candidate, gain: float, hints: list[Hint]) -> list[Hint]:
    """Return the hints that may take the place of ``own``, which gains so much [nats] there.

    Those that are known to resemble it, explain as much, or have a signature like its own.
    """
    signature = next((hint.signature for hint in hints if hint.candidate.name == own.name), np.zeros(0))

    def resembles(hint: Hint) -> bool:
        alike = abs(float(signature @ hint.signature)) if signature.size else 0.0
        return hint.gain >= thresholds.MIN_GAIN_NATS and (
            hint.gain >= thresholds.PLACE_SHARE * gain or alike >= thresholds.PLACE_COSINE
        )

    others = [h for h in hints if h.candidate.name != own.name]
    kin = [h for h in others if are_kin(h.candidate.effect, own.effect)]
    more = [h for h in others if h not in kin and resembles(h)]
    return kin + more[: max(thresholds.MAX_REFITS - len(kin), 0)]


def _step(base: CandidateFit, groups: Floats, found: Search, threads: int, report: Report) -> Step:
    model = base.problem.model
    if "K" in model.values:  # the scale of forces, which a saturation is measured by
        model = model.with_value("K", base.value("K"))
    possible, out_of_sight = candidates(model, base.problem.measured)
    groups_taken = {one.candidate.effect.group for one in found.accepted} - {""}  # never distinguished
    possible = [c for c in possible if c.effect.group not in groups_taken and c.name not in found.dropped]
    found.out_of_sight = found.out_of_sight or out_of_sight
    report(f"screens {len(possible)} effects")
    hints = screen_candidates(base.problem, base.optimum, possible, threads)
    chosen = shortlist(hints)
    report("refits " + (", ".join(hint.candidate.name for hint in chosen) or "none"))
    misfit = found.misfit(base)
    first = found.steps[0].base if found.steps else base
    accepted = [one.candidate.effect for one in found.accepted]
    asked = required_evidence(first, base, misfit, accepted)
    form = form_directions(accepted, base) if accepted else None

    def tried_of(hint: Hint, new: CandidateFit) -> Tried:
        change = base.whitened(new) - base.optimum.residual
        pays = asked.of(hint.candidate.effect, change, is_exact=found.leaves_noise(new))
        regimes = misfit, found.misfit(new)
        verdict = judge_candidate(hint.candidate, base, new, regimes, pays, asked.left, form)
        return Tried(hint.candidate, new.without_derivatives(), verdict, change)

    found.refitted = {}
    fits = _refitted(base, chosen, groups, threads, report, found.refitted, asked)
    tried = [tried_of(hint, new) for hint, new in zip(chosen, fits, strict=True)]
    is_passed = any(one.verdict.is_passed for one in tried if not one.fitted.optimum.is_given_up)
    if base.error > thresholds.FAR_ERROR and not is_passed:
        behind = [h for h, new in zip(chosen, fits, strict=True) if new.optimum.is_given_up]
        tried = [one for one in tried if not one.fitted.optimum.is_given_up]
        most = [base.optimum.cost - asked.at_least(hint.candidate.effect) for hint in behind]
        tried += [
            tried_of(hint, extend_problem(base, hint, groups, cost))
            for hint, cost in zip(behind, most, strict=True)
        ]
    give_back_memory(base.optimum.residual.size)
    return Step(base, hints, sorted(tried, key=lambda one: -one.verdict.gain))


def _refitted(
    base: CandidateFit,
    chosen: list[Hint],
    groups: Floats,
    threads: int,
    report: Report = lambda _: None,
    done: dict[str, tuple[float, float]] | None = None,
    asked: EvidenceThreshold | None = None,
) -> list[CandidateFit]:
    """Return the fits with what was ``chosen``, given up where they cannot gain what is ``asked``.

    Far from the noise, those far behind the best are given up as well.
    """
    done = {} if done is None else done

    def refit(hint: Hint, least: float) -> CandidateFit:
        if asked is not None:
            least = min(least, base.optimum.cost - asked.at_least(hint.candidate.effect))
        new = extend_problem(base, hint, groups, least)
        done[hint.candidate.name] = new.evidence, new.error
        left = ", ".join(h.candidate.name for h in chosen if h.candidate.name not in done) or "none"
        report(f"error {base.error:.3g}, {best_of(done)}; left: {left}")
        return new

    fits: list[CandidateFit] = []
    gained, least = 0.0, math.inf  # [nats] of the best one, the cost from which a candidate contends
    with ThreadPoolExecutor(threads) as pool:
        while len(fits) < len(chosen):  # as many as run at a time, so that the bound does not hang on chance
            some = chosen[len(fits) : len(fits) + threads]
            fits += pool.map(refit, some, itertools.repeat(least))
            gained = max(gained, *(one.evidence - base.evidence for one in fits))
            if base.error > thresholds.FAR_ERROR:
                least = base.optimum.cost - thresholds.CONTENDER_SHARE * gained
        contends = base.evidence + thresholds.CONTENDER_SHARE * gained

        def finish(one: CandidateFit) -> CandidateFit:
            may_win = one.evidence >= contends and not one.optimum.is_given_up
            return finish_fit(base, one, groups) if may_win else one

        return list(pool.map(finish, fits))


def best_of(refitted: Mapping[str, tuple[float, float]]) -> str:
    """Return in words which of the candidates explains most, of evidence [nats] and error of each."""
    name = max(refitted, key=lambda one: refitted[one][0])
    return f"best so far {refitted[name][1]:.3g} with {name}"


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


def _without(fitted: CandidateFit, *some: Candidate) -> Problem:
    problem = fitted.problem
    own = {p.symbol for one in some for p in one.effect.parameters}
    names = [one.name for one in some]
    effects = tuple(one for one in problem.model.effects if one.name not in names)
    values = {symbol: value for symbol, value in problem.model.values.items() if symbol not in own}
    model = dataclasses.replace(problem.model, effects=effects, values=values)
    symbols = tuple(s for s in problem.symbols if s not in own)
    within = compiled_already(problem, model)
    return Problem(model, problem.measured, symbols=symbols, like=problem, within=within)


def _shared(fitted: CandidateFit, other: Problem) -> Floats:
    known = dict(zip(fitted.problem.unknowns.names, fitted.optimum.u, strict=True))
    return np.array([known[name] for name in other.unknowns.names])
