"""The verdict: what changed between two recordings, as far as both show.

* nothing: no difference is more than the noise of both,
* named: these values differ, each with its interval,
* ambiguous: one of several does, and what would decide which,
* new_effect: the second shows an effect that the first does not.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vegrip.effects import effect
from vegrip.errors import RecordingError, UsageError
from vegrip.identification.changed.choice import Choice, Set, chance, choose
from vegrip.identification.changed.pair import Pair
from vegrip.identification.changed.words import Change, advice_for, label_of
from vegrip.identification.compare.where import format_span
from vegrip.identification.diagnosis import diagnose, thresholds
from vegrip.identification.diagnosis.acceptance import misfit_by_regime
from vegrip.identification.diagnosis.candidate_fit import regime_map
from vegrip.identification.diagnosis.data_checks import check_before_search, refuse_unusable
from vegrip.identification.diagnosis.score_tests import candidate_of, screen_candidates, why_unseen
from vegrip.identification.fit.excerpt import excerpt
from vegrip.identification.fit.fitting import base_model, fit, on_one_thread
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.problem import AT, Problem
from vegrip.identification.fit.result import MISFIT, Fit, overall_error
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.types import Floats

SIDE_95 = 1.96  # standard errors to either side of an interval of 95 %
VAGUE_PERCENT = 100.0  # from which a value that may have changed so much is not said to be unchanged
MIN_WARMER_K = 1.0  # [K] from which a difference of the temperatures is reported
OUTERMOST = 0.05  # of the rows, which do not count for what was shown
EXPLAINED = ("named", "ambiguous")  # verdicts of a diagnosis
COUNTS = ("none", "one", "two", "three", "four")


@dataclass(frozen=True, eq=False)
class Changed:
    """What changed from the first recording to the second."""

    pair: Pair
    choice: Choice
    new_effects: tuple[str, ...]  # which the second shows alone
    overlap: dict[str, Any]  # channels, depths [m] and speeds [m/s] of both
    doubts: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """nothing, named, ambiguous or new_effect."""
        if self.new_effects:
            return "new_effect"
        return "ambiguous" if self.choice.unsure else "named" if self.choice.best else "nothing"

    @cached_property
    def changes(self) -> list[Change]:
        """Every value that changed, or may have: those that are sure first."""
        order = [*self.choice.sure, *(j for _, group in self.choice.unsure for j in group)]
        sets = (self.choice.best, *self.choice.rivals)
        return [self._change(j, next(one for one in sets if j in one)) for j in order]

    def _change(self, j: int, among: Set) -> Change:
        """Return the change of ``j`` where these differ, and nothing else."""
        pair, name, (w, cost) = self.pair, self.pair.names[j], self.pair.solved(among)
        d, std = float(w[pair.kept + j]), float(pair.std(among)[among.index(j)])
        without = tuple(one for one in among if one != j)
        p = chance(pair.cost(without) - cost, 1, len(pair.questions))
        problem = pair.first
        is_gain = j >= len(problem.unknowns.names)
        units = {"zero_displacement": problem.depth, "zero_force": problem.load}
        unit = (units | {"tip_radius": problem.model.tip_radius}).get(name, 1.0)
        u = 0.0 if is_gain else float(w[j])
        moved = np.array([0.0, d, d - SIDE_95 * std, d + SIDE_95 * std])
        is_log = is_gain or problem.unknowns.log[j]
        before, after, low, high = (unit * (np.exp(u + moved) if is_log else u + moved)).tolist()
        is_zero = name.startswith("zero_") or not before
        scale = 1.0 if is_zero else 100.0 / abs(before)
        interval = scale * (low - before), scale * (high - before)
        percent = None if is_zero else scale * (after - before)
        return Change(_public(name), before, after, (high - low) / (2.0 * SIDE_95), percent, interval, p)

    @property
    def indistinguishable(self) -> list[list[str]]:
        return [[_public(self.pair.names[j]) for j in group] for _, group in self.choice.unsure]

    @property
    def experiment(self) -> list[dict[str, Any]]:
        """What would distinguish the members of each set that both recordings do not."""
        model, sets = self.pair.second.model, zip(self.choice.unsure, self.indistinguishable, strict=True)
        few = [(one, len(one) - count) for (count, _), one in sets]  # what is not there, one by one
        return [{"between": one, "advice": advice_for(one, count, model)} for one, count in few]

    @cached_property
    def unchanged(self) -> list[Change]:
        """By how much each other value can have changed, if it did beside those that did."""
        rest = [j for j in self.pair.questions if not any(j in one for one in self.choice.rivals)]
        found = [self._change(j, (*self.choice.best, j)) for j in rest]
        return [one for one in found if one.percent is None or max(map(abs, one.interval)) < VAGUE_PERCENT]

    def _label(self, name: str) -> str:
        return label_of(name, self.pair.second.model)

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        descriptions = {one.name: one.described(self._label(one.name)) for one in self.changes}
        new = [f"{' and '.join(self.new_effects)} in the second only"] * bool(self.new_effects)
        sure = [descriptions[_public(self.pair.names[j])] for j in self.choice.sure]
        sets = [
            f"{COUNTS[count]} of these: {' or '.join(descriptions[name] for name in names)}"
            for (count, _), names in zip(self.choice.unsure, self.indistinguishable, strict=True)
        ]
        end = [] if sets else ["nothing else"] if new or sure else ["nothing changed"]
        first = self.pair.first.measured.recording
        who = first.name if first.is_material else first.fingertip.name
        return f"{who}: {', '.join([*new, *sure, *sets, *end])}"

    @property
    def remarks(self) -> Iterator[str]:
        """What else is to be known, in sentences."""
        yield from (f"to distinguish them: {one['advice']}" for one in self.experiment)
        within = {one.name: max(map(abs, one.interval)) for one in self.unchanged}
        descriptions = [
            f"{self._label(one.name)} {one.amount(within[one.name])[1:]}" for one in self.unchanged
        ]
        if descriptions:
            yield f"unchanged, each by itself with 95 % within: {', '.join(descriptions)}"
        known = {*within, *(one.name for one in self.changes)}
        if unseen := [self._label(name) for name in map(_public, self.pair.names) if name not in known]:
            yield f"not compared, for both do not show it: {', '.join(unseen)}"
        yield from self.doubts

    def __str__(self) -> str:
        return "\n".join([self.sentence, *self.remarks])

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "changed": [asdict(one) for one in self.changes],
            "indistinguishable": self.indistinguishable,
            "new_effects": list(self.new_effects),
            "experiment": {"sets": self.experiment} if self.experiment else None,
            "unchanged": [asdict(one) for one in self.unchanged],
            "overlap": self.overlap,
            "doubts": list(self.doubts),
        }


@on_one_thread
def changed(
    first: Recording,
    second: Recording,
    model: ContactModel | None = None,
    *,
    tolerance: float = 0.0,
    report: Report = lambda _: None,
) -> Changed:
    """Say what changed of a fingertip between two recordings.

    Both are fitted with one model, and each value may differ: by itself, then in sets, by the likelihood
    ratio with the noise of both, corrected for the number of questions. What the model lacks in the first is
    looked for in the catalogue and added for both; what it lacks in the second alone is a new effect.

    Args:
        first: a recording, such as of Monday.
        second: of the same fingertip, such as of Friday.
        model: of both; the paper's when not given.
        tolerance: share of an episode's peak force by which the model may be wrong.
        report: called with the progress.

    Raises:
        UsageError: something else than a recording was given.
        RecordingError: one lacks what a fit needs, or they have no depths or speeds in common; says what.

    """
    both = (first, second)
    for one in both:
        if not isinstance(one, Recording):
            raise UsageError(f"changed compares two recordings; give a Recording, not a {type(one).__name__}")
        if not len(one):
            raise RecordingError(f"{one.name} has no episode; give a recording with a press in it")
    if (first.is_material, first.is_step) != (second.is_material, second.is_step):
        raise RecordingError(f"of {first.name} and {second.name} only one is of a material without a contact")
    noises = [noise_of(excerpt(one)).tolerant(tolerance) for one in both]

    def fitted(like: ContactModel) -> list[Fit]:
        return [fit(one, like, noise=noise, report=report) for one, noise in zip(both, noises, strict=True)]

    like = model or base_model(first)
    a, b = fitted(like)
    overlap = _overlap(a, b)
    if _lacks(a.problem, a.optimum.u):
        found = diagnose(first, like, noise=noises[0], report=report)
        if found.verdict in EXPLAINED:
            like = found.model
            a, b = fitted(like)
    pair = Pair(a, b)
    choice, new = choose(pair), tuple[str, ...]()
    second_at = pair.side(1, pair.w)[0]
    if _lacks(pair.second, second_at) and not _lacks(a.problem, a.optimum.u):
        found = diagnose(second, like, noise=noises[1], report=report)
        names = tuple(one.candidate.name for one in found.search.accepted)
        if found.verdict in EXPLAINED:
            is_old = any(_gain(a, name) > thresholds.MIN_GAIN_NATS for name in names)
            other = Pair(*fitted(found.model)) if is_old else Pair(a, found.result)
            rival = choose(other)
            if _cost(pair) - _cost(other) > thresholds.MIN_GAIN_NATS:
                sets = {one[0]: " or ".join(one) for one in found.indistinguishable}
                pair, choice = other, rival
                new = () if is_old else tuple(sets.get(name, name) for name in names)
        elif found.verdict == "unexplained" and a.error < MISFIT < overall_error(pair.second, second_at):
            new = ("something that no effect explains",)
    return Changed(pair, choice, new, overlap, tuple(_doubts(pair)))


def _lacks(problem: Problem, u: Floats) -> bool:
    """Whether more than noise is left in the regimes."""
    return misfit_by_regime(problem.residual(u), regime_map(problem, u)) > thresholds.MAX_NOISE_CHI2


def _cost(pair: Pair) -> float:
    """Return what both leave where they are [nats]: a new effect has to pay beside what differs."""
    left = [one.residual(pair.side(i, pair.w)[0]) for i, one in enumerate((pair.first, pair.second))]
    noise = sum(float(np.sum(one.log_scale)) for one in (pair.first, pair.second))
    return noise + 0.5 * sum(float(r @ r) for r in left)


def _gain(one: Fit, name: str) -> float:
    """Return what an effect would explain of a recording [nats]; 0 where it cannot show."""
    if why_unseen(effect(name), one.problem.measured):
        return 0.0
    tried = candidate_of(effect(name), one.problem.model, one.problem.measured)
    return max((hint.gain for hint in screen_candidates(one.problem, one.optimum, [tried])), default=0.0)


def _public(unknown: str) -> str:
    return "zero_normal_force" if unknown == "zero_force" else unknown


def _overlap(a: Fit, b: Fit) -> dict[str, Any]:
    """Return what both recordings show.

    Raises:
        RecordingError: they have no depth or no speed in common.

    """
    mine, its = (set(one.problem.measured.recording.columns) for one in (a, b))
    descriptions: dict[str, Any] = {"first_only": sorted(mine - its), "second_only": sorted(its - mine)}
    descriptions["channels"] = sorted(mine & its)
    spans = zip(("indentation", "speed"), thresholds.SAME_MOTION, _shown(a), _shown(b), strict=False)
    for name, factor, one, other in spans:
        descriptions[name] = {"first": one, "second": other}
        if one[0] > factor * other[1] or other[0] > factor * one[1]:
            raise RecordingError(
                f"the recordings do not overlap: the first is pressed {format_span(name, *one)}, the second "
                f"{format_span(name, *other)}; record the second again with the motion of the first"
            )
    return descriptions


def _shown(one: Fit) -> Iterator[list[float]]:
    """Yield the depths [m] and speeds [m/s] in contact, without the outermost."""
    problem, m = one.problem, one.problem.measured
    refuse_unusable(m.recording, m)
    rows = problem.stiffness > 0.0
    if not rows.any():
        raise RecordingError(f"{m.recording.name}: the model never touches in it, so nothing is compared")
    speed = np.abs(np.gradient(m.motion.displacement, m.recording.t))[rows]
    depth = problem.table(one.optimum.u)[rows, AT["indentation"]]
    for values in (depth, speed[speed > OUTERMOST * speed.max()]):
        ends = np.quantile(values, (OUTERMOST, 1.0 - OUTERMOST)) if values.size else np.zeros(2)
        yield ends.tolist()


def _doubts(pair: Pair) -> Iterator[str]:
    both = (pair.first, pair.second)
    first, second = (one.measured.recording for one in both)
    for i, problem in enumerate(both):
        name, error = problem.measured.recording.name, overall_error(problem, pair.side(i, pair.w)[0])
        yield from (f"{name}: {doubt.text}" for doubt in check_before_search(problem))
        if error > MISFIT:
            yield f"{name}: the model leaves {error:.2f} times the noise, which widens the intervals"
    if not first.is_material and first.fingertip.radius != second.fingertip.radius:
        yield f"the stated radii differ; {1e3 * pair.first.model.tip_radius:.3g} mm is taken for both"
    if "temperature" in first.columns.keys() & second.columns.keys():
        cold, warm = (float(np.nanmedian(one.columns["temperature"])) for one in (first, second))
        if abs(warm - cold) > MIN_WARMER_K:
            yield f"the second was {warm - cold:+.1f} K warmer, which by itself changes stiffness and memory"
