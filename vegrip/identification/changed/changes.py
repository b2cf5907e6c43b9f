"""The verdict: what changed between two recordings, as far as both show.

* nothing: no difference is more than the noise of both,
* named: these values differ, each with its interval,
* ambiguous: one of several does, and what would decide which,
* new_effect: the second shows an effect that the first does not.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from vegrip.effects import effect
from vegrip.errors import RecordingError, UsageError
from vegrip.identification.changed.choice import choose
from vegrip.identification.changed.pair import Pair
from vegrip.identification.changed.result import Changed
from vegrip.identification.compare.where import features_of, format_span
from vegrip.identification.diagnosis import Diagnosis, diagnose, thresholds
from vegrip.identification.diagnosis.acceptance import misfit_by_regime
from vegrip.identification.diagnosis.candidate_fit import regime_map
from vegrip.identification.diagnosis.data_checks import check_before_search, refuse_unusable
from vegrip.identification.fit.excerpt import excerpt
from vegrip.identification.fit.fitting import base_model, fit, on_one_thread
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.result import MISFIT, Fit, overall_error
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.parameters import coordinate
from vegrip.types import Floats

MIN_WARMER_K = 1.0  # [K] from which a difference of the temperatures is reported
OUTERMOST = 0.05  # of the rows, or of the greatest value, which does not count for what was shown
WHICH = ("the first", "the second")  # recordings: both may have one name
EXPLAINED = ("named", "ambiguous")  # verdicts of a diagnosis


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

    def diagnosed(which: int) -> Diagnosis:
        return diagnose(both[which], a.problem.model, noise=noises[which], report=report)

    a, b = fitted(model or base_model(first))
    doubts = [text for which, one in zip(WHICH, (a, b), strict=True) for text in _doubts(which, one.problem)]
    overlap = _overlap(a, b)
    if _lacks(a.problem, a.optimum.u) and (found := diagnosed(0)).verdict in EXPLAINED:
        a, b = fitted(found.model)
    pair, new = Pair(a, b, {}), tuple[str, ...]()
    choice = choose(pair)
    if _lacks(*pair.sides(pair.w)[1]) and not _lacks(a.problem, a.optimum.u):
        found = diagnosed(1)
        if found.verdict in EXPLAINED:
            names = [one.candidate.name for one in found.search.accepted]
            sets = {one[0]: " or ".join(one) for one in found.indistinguishable}
            in_second = _absent(names), tuple(sets.get(name, name) for name in names)
            a_with, b_with = fitted(found.model)
            for absent, effects in (in_second, ({}, ())):  # in the second alone, then in both
                richer = Pair(a_with, b_with, absent)
                rival = choose(richer)
                if pair.left - richer.left > thresholds.MIN_GAIN_NATS:  # it pays beside what differs
                    pair, choice, new = richer, rival, effects
        elif found.verdict == "unexplained" and a.error < MISFIT < overall_error(*pair.sides(pair.w)[1]):
            new = ("something that no effect explains",)
    return Changed(pair, choice, new, overlap, [*doubts, *_differences(pair)])


def _lacks(problem: Problem, u: Floats) -> bool:
    """Whether more than noise is left in the regimes."""
    return misfit_by_regime(problem.residual(u), regime_map(problem, u)) > thresholds.MAX_NOISE_CHI2


def _absent(names: list[str]) -> dict[str, float]:
    """Return the coordinates of the values of effects at which there is nothing of them."""
    every = [p for name in names for p in effect(name).parameters]
    return {p.symbol: coordinate(p, p.default if p.null is None else p.null) for p in every}


def _overlap(a: Fit, b: Fit) -> dict[str, Any]:
    """Return what both recordings show.

    Raises:
        RecordingError: they have no depth or no speed in common.

    """
    mine, its = (one.recording.columns.keys() for one in (a, b))
    overlap: dict[str, Any] = {"first_only": sorted(mine - its), "second_only": sorted(its - mine)}
    overlap["channels"] = sorted(mine & its)
    for name, factor in zip(("indentation", "speed"), thresholds.SAME_MOTION, strict=False):
        one, other = _shown(a, name), _shown(b, name)
        overlap[name] = {"first": one, "second": other}
        if one[0] > factor * other[1] or other[0] > factor * one[1]:
            raise RecordingError(
                f"the recordings do not overlap: the first is pressed {format_span(name, *one)}, the second "
                f"{format_span(name, *other)}; record the second again with the motion of the first"
            )
    return overlap


def _shown(one: Fit, name: str) -> list[float]:
    """Return the range of a feature in contact, without the outermost."""
    values = features_of(one.problem, one.optimum.u).values[name][one.problem.stiffness > 0.0]
    inner = values[values >= OUTERMOST * values.max()]
    return [float(end) for end in np.quantile(inner, (OUTERMOST, 1.0 - OUTERMOST))]


def _doubts(which: str, problem: Problem) -> list[str]:
    """Return what is wrong with a recording by itself.

    Raises:
        RecordingError: nothing can be concluded from it.

    """
    recording = problem.measured.recording
    refuse_unusable(recording, problem.measured)
    return [f"{which}: {doubt.text}" for doubt in check_before_search(problem)]


def _differences(pair: Pair) -> Iterator[str]:
    """Yield what else may look like a change."""
    first, second = (problem.measured.recording for problem, _ in pair.sides(pair.w))
    for which, side in zip(WHICH, pair.sides(pair.w), strict=True):
        if (error := overall_error(*side)) > MISFIT:
            yield f"{which}: the model leaves {error:.2f} times the noise, which widens the intervals"
    if not first.is_material and first.fingertip.radius != second.fingertip.radius:
        yield f"the stated radii differ; {1e3 * pair.first.model.tip_radius:.3g} mm is taken for both"
    if "temperature" in first.columns.keys() & second.columns.keys():
        cold, warm = (float(np.nanmedian(one.columns["temperature"])) for one in (first, second))
        if abs(warm - cold) > MIN_WARMER_K:
            yield f"the second was {warm - cold:+.1f} K warmer, which by itself changes stiffness and memory"


def changed_fingers(
    first: Mapping[str, Recording],
    second: Mapping[str, Recording],
    model: ContactModel | None = None,
    *,
    tolerance: float = 0.0,
    report: Report = lambda _: None,
) -> tuple[dict[str, Changed], dict[str, str]]:
    """Say what changed of every finger, by its name, as :func:`~vegrip.changed` does of one.

    Returns what changed of those that both recordings show, and why others are not compared.

    Raises:
        RecordingError: no finger can be compared; says why.

    """
    found = dict[str, Changed]()
    not_compared = {one: "only the first recording has it" for one in first if one not in second}
    not_compared |= {one: "only the second recording has it" for one in second if one not in first}
    for finger in (one for one in first if one in second):

        def told(text: str, finger: str = finger) -> None:
            report(f"{finger}: {text}")

        try:
            found[finger] = changed(first[finger], second[finger], model, tolerance=tolerance, report=told)
        except RecordingError as error:
            not_compared[finger] = str(error)
    if not found:
        each = [f"{finger}: {reason}" for finger, reason in not_compared.items()]
        raise RecordingError("; ".join(each if len(each) > 1 else not_compared.values()))
    return found, not_compared
