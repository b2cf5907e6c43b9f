"""The ladder of errors: from the model that was given, effect by effect, down to the noise."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from vegrip.effects import effect
from vegrip.errors import UsageError
from vegrip.identification.diagnosis import candidate_fit, score_tests
from vegrip.identification.diagnosis.diagnosis import Diagnosis, diagnose
from vegrip.identification.diagnosis.search import drop_unneeded
from vegrip.identification.fit.fitting import on_one_thread
from vegrip.identification.fit.noise import Noise
from vegrip.identification.fit.problem import Zeros
from vegrip.identification.fit.result import Fit, fit_of
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.plotting import new_figure, save_figure


@dataclass(frozen=True)
class Rung:
    """One model: the effect that came in (none for the first), its error in training and held out."""

    effect: str | None
    error: float
    heldout_error: float


@dataclass(frozen=True)
class Refinement:
    """A model with the effects that pay, and the ladder of errors that led there."""

    diagnosis: Diagnosis
    rungs: list[Rung]

    @property
    def model(self) -> ContactModel:
        return self.diagnosis.model


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
    return Refinement(found, build_ladder(found))


def build_ladder(found: Diagnosis) -> list[Rung]:
    """Return the rungs of a diagnosis, from the first model to the last."""
    steps = found.search.steps
    rungs = [Rung(None, steps[0].base.error, steps[0].base.heldout_error)]
    for step, after in pairwise(steps):
        if step.taken is not None:
            rungs.append(Rung(step.taken.candidate.name, after.base.error, after.base.heldout_error))
    return rungs


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


def draw_ladder(rungs: list[Rung], path: Path) -> None:
    """Draw the ladder."""
    figure, (axis,) = new_figure(size=(7, 4))
    names = ["start", *(f"+ {rung.effect}" for rung in rungs[1:])]
    axis.semilogy(names, [rung.error for rung in rungs], "o-", label="training")
    axis.semilogy(names, [rung.heldout_error for rung in rungs], "s--", label="held-out episodes")
    axis.axhline(1.0, color="0.6", lw=1)
    axis.set_ylabel("error / noise")
    axis.legend()
    save_figure(figure, path)
