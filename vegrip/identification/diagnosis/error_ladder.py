"""The ladder of errors: from the model that was given, effect by effect, down to the noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vegrip.displayed import Result
from vegrip.effects import effect
from vegrip.errors import KindError, UsageError
from vegrip.identification.diagnosis import candidate_fit, score_tests
from vegrip.identification.diagnosis.diagnosis import Diagnosis, diagnose
from vegrip.identification.diagnosis.search import drop_unneeded
from vegrip.identification.fit.fitting import on_one_thread
from vegrip.identification.fit.given import named_kind, on_recording
from vegrip.identification.fit.noise import Noise
from vegrip.identification.fit.problem import Zeros
from vegrip.identification.fit.result import Fit, fit_of
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.plotting import new_figure, save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Rung:
    """One model: the effect that came in (none for the first), its error in training and held out."""

    effect: str | None
    error: float
    heldout_error: float


@dataclass(frozen=True, repr=False)
class Ladder(Result):
    """The error of one model after the other of one recording.

    Attributes:
        rungs: the effect that came in (None for the first), error and held-out error over the noise.
        recording: name of the recording.

    """

    _display: ClassVar[str] = "ladder"

    rungs: list[Rung]
    recording: str


@dataclass(frozen=True, repr=False)
class Refinement(Ladder):
    """A model with the effects that pay, and the ladder of errors that led there.

    Attributes:
        model: with the effects that pay.
        rungs: the effect that came in (None for the first), error and held-out error over the noise.
        recording: name of the recording.
        diagnosis: the search behind it.

    """

    diagnosis: Diagnosis

    @property
    def model(self) -> ContactModel:
        return self.diagnosis.model


@on_recording
def refine(
    recording: Recording,
    model: ContactModel | None = None,
    *,
    noise: Noise | None = None,
    zeros: Zeros = "recording",
    most: int = 4,
    report: Report = lambda _: None,
) -> Refinement:
    """Add effect after effect to ``model``, refitting each time, until the next one does not pay.

    Arguments and errors are those of :func:`~vegrip.identification.diagnosis.diagnose`.
    """
    found = diagnose(recording, model, noise=noise, zeros=zeros, most=most, report=report)
    return Refinement(build_ladder(found), found.start.recording.name, found)


def build_ladder(found: Diagnosis) -> list[Rung]:
    """Return the rungs of a diagnosis, from the first model to the last."""
    steps = found.search.steps
    rungs = [Rung(None, steps[0].base.error, steps[0].base.heldout_error)]
    for step, after in pairwise(steps):
        if step.taken is not None:
            rungs.append(Rung(step.taken.candidate.name, after.base.error, after.base.heldout_error))
    return rungs


def ladder(fits: Sequence[Fit]) -> Ladder:
    """Return the ladder of ``fits`` of one recording, in their order: ``ladder([start, better])``.

    Held-out errors are those of each episode under a fit without it.

    Raises:
        UsageError: there is none, or they are of several recordings.

    """
    given: Any = fits
    wrong = [given] if not isinstance(given, Sequence) else [one for one in given if not isinstance(one, Fit)]
    if wrong:
        raise KindError(
            f"ladder wants fits of one recording, [fit1, fit2], and was given {named_kind(wrong[0])}"
        )
    if not fits:
        raise UsageError("ladder wants at least one fit, and was given none")
    first, names = fits[0].recording, [[one.name for one in each.model.effects] for each in fits]
    for each in fits:
        if not _is_same(first, each.recording):
            raise UsageError(
                f"the fits are of several recordings, {first.name} and {each.recording.name}; their errors "
                "do not compare: fit both models to one"
            )
    steps = [None, *(_step(*pair) for pair in pairwise(names))]
    return Ladder([_rung(name, each) for name, each in zip(steps, fits, strict=True)], first.name)


def _is_same(one: Recording, other: Recording) -> bool:
    if one is other:
        return True
    is_timed_alike = np.array_equal(one.t, other.t) and one.columns.keys() == other.columns.keys()
    return is_timed_alike and all(
        np.array_equal(values, other.columns[name], equal_nan=True) for name, values in one.columns.items()
    )


def _step(before: list[str], after: list[str]) -> str:
    """Return what came in from one model to the next, and what went."""
    changes = [name for name in after if name not in before]
    changes += [f"without {name}" for name in before if name not in after]
    return ", ".join(changes) or "other values"


def _rung(name: str | None, of: Fit) -> Rung:
    judged = candidate_fit.evaluate_candidate(
        of.problem, of.optimum, candidate_fit.held_out_groups(of.problem)
    )
    return Rung(name, of.error, judged.heldout_error)


@on_one_thread
def add_effect(name: str, start: Fit) -> tuple[Fit, candidate_fit.CandidateFit]:
    """Put the effect ``name`` into a fitted model and fit again; return that fit, and the model before.

    Raises:
        InputError: the file that ``name`` is cannot be read.
        ModelError: there is no such effect, or it does not go with the model.
        UsageError: the model has it, or the recording cannot show it.

    """
    problem, added = start.problem, effect(name)
    if added.name in {one.name for one in problem.model.effects}:
        raise UsageError(f"the model has {added.name} already; fit it with `vegrip fit --model`")
    if reason := score_tests.why_unseen(added, problem.measured):
        raise UsageError(f"this recording cannot show {added.name}: {reason}")
    problem.model.with_effect(added)
    candidate = score_tests.candidate_of(added, problem.model, problem.measured)
    groups = candidate_fit.held_out_groups(problem)
    base = candidate_fit.evaluate_candidate(problem, start.optimum, groups)
    last = drop_unneeded(candidate_fit.extend_problem(base, _hint(base, candidate), groups), groups)
    return fit_of(last.problem, last.optimum), base


def _hint(base: candidate_fit.CandidateFit, candidate: score_tests.Candidate) -> score_tests.Hint:
    hints = score_tests.screen_candidates(base.problem, base.optimum, [candidate])
    if hints:
        return hints[0]
    return score_tests.Hint(candidate, 0.0, candidate.trials[0], 1.0, np.zeros(base.optimum.residual.size))


def ladder_figure(rungs: list[Rung]) -> "Figure":
    """Return the picture of a ladder."""
    figure, (axis,) = new_figure(size=(7, 4))
    names = ["start", *(f"+ {rung.effect}" for rung in rungs[1:])]
    axis.semilogy(names, [rung.error for rung in rungs], "o-", label="training")
    axis.semilogy(names, [rung.heldout_error for rung in rungs], "s--", label="held-out episodes")
    axis.axhline(1.0, color="0.6", lw=1, label="noise")
    axis.yaxis.set_minor_formatter("{x:g}")
    axis.yaxis.set_major_formatter("{x:g}")
    axis.margins(x=0.15)
    axis.set_xlabel("model")
    axis.set_ylabel("error / noise [1]")
    axis.legend()
    return figure


def draw_ladder(rungs: list[Rung], path: Path) -> None:
    save_figure(ladder_figure(rungs), path)
