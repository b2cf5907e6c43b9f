"""From a recording to a fitted model, in one call."""

import math

from vegrip.errors import RecordingError
from vegrip.identification.fit.blas import on_one_thread
from vegrip.identification.fit.noise import Noise, noise_of
from vegrip.identification.fit.preprocess import preprocess
from vegrip.identification.fit.problem import Problem, Zeros
from vegrip.identification.fit.result import Fit, fit_of
from vegrip.identification.fit.solve import Report, fit_problem
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel, paper_model


@on_one_thread
def fit(
    recording: Recording,
    model: ContactModel | None = None,
    *,
    noise: Noise | None = None,
    zeros: Zeros = "recording",
    report: Report = lambda _: None,
) -> Fit:
    """Fit ``model`` to ``recording``: normal force, load at slip and contact radius together.

    Args:
        recording: with displacement and normal force; slip and contact radius where it has them.
        model: its values are the start and the middle of a wide prior, those with ``std = 0`` are kept;
            the paper's model when not given.
        noise: of the sensors; as :func:`vegrip.identification.fit.noise.noise_of` finds it when not given.
        zeros: whether the zeros of displacement and force are the same for the recording, each episode's, or
            those of a group of episodes: the group of each episode, such as the trial that it is from.
        report: called with the progress.

    Raises:
        RecordingError: the recording lacks what a fit needs; says what.

    """
    measured = preprocess(recording, noise or noise_of(recording))
    problem = Problem(model or base_model(recording), measured, zeros=zeros)
    return fit_of(problem, fit_problem(problem, report))


def base_model(recording: Recording) -> ContactModel:
    """Return the paper's model for the recorded fingertip.

    Raises:
        RecordingError: its radius is not known.

    """
    radius = recording.fingertip.radius
    if not math.isfinite(radius):
        raise RecordingError(
            f"{recording.name} does not state the radius of the fingertip; "
            "add it to recording.toml, [fingertip] radius in m, or give a model"
        )
    return paper_model(radius)
