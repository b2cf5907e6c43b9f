"""From a recording to a fitted model, in one call."""

import math
from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numpy as np
from threadpoolctl import threadpool_limits

from vegrip.errors import RecordingError
from vegrip.identification.fit.excerpt import excerpt
from vegrip.identification.fit.given import on_recording
from vegrip.identification.fit.noise import Noise, noise_of
from vegrip.identification.fit.preprocess import preprocess
from vegrip.identification.fit.problem import Problem, Zeros
from vegrip.identification.fit.result import Fit, fit_of
from vegrip.identification.fit.solve import Optimum, Report, fit_problem
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel, material_model, paper_model

P = ParamSpec("P")
R = TypeVar("R")


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Let ``function`` run without BLAS threads of its own; several of it may still run side by side.

    The matrices here are small, and BLAS threads that wait for them spin.
    """
    return cast("Callable[P, R]", threadpool_limits.wrap(limits=1, user_api="blas")(function))


@on_recording
@on_one_thread
def fit(
    recording: Recording,
    model: ContactModel | None = None,
    *,
    noise: Noise | None = None,
    zeros: Zeros = "recording",
    laws: Zeros = "recording",
    report: Report = lambda _: None,
) -> Fit:
    """Fit ``model`` to ``recording``: normal force, load at slip and contact radius together.

    Args:
        recording: with displacement and normal force; slip and contact radius where it has them. Of more
            than :data:`vegrip.identification.fit.excerpt.MOST_ROWS` rows an :func:`excerpt` is fitted.
        model: its values are the start and the middle of a wide prior, those with ``std = 0`` are kept;
            the paper's model when not given.
        noise: of the sensors; as :func:`vegrip.identification.fit.noise.noise_of` finds it when not given.
        zeros: whether the zeros of displacement and force are the same for the recording, each episode's, or
            those of a group of episodes: the group of each episode, such as the trial that it is from.
        laws: the same of K and p, where more than one place or specimen was pressed.
        report: called with the progress.

    Raises:
        RecordingError: the recording lacks what a fit needs; says what.

    """
    return fit_of(*solve(recording, model, noise=noise, zeros=zeros, laws=laws, report=report))


def solve(
    recording: Recording,
    model: ContactModel | None,
    *,
    noise: Noise | None,
    zeros: Zeros,
    report: Report,
    laws: Zeros = "recording",
    symbols: tuple[str, ...] | None = None,
) -> tuple[Problem, Optimum]:
    """Return the problem of ``model``, the paper's when not given, and where it is at its best.

    The arguments are those of :func:`fit`; ``symbols``: parameters to fit, none for a model as it is.
    """
    recording = used_of(recording, zeros, laws)
    measured = preprocess(recording, noise or noise_of(recording))
    plain = Problem(base_model(recording, model), measured, zeros=zeros, laws=laws)
    if model is None:
        return plain, fit_problem(plain, report)
    problem = Problem(model, measured, zeros=zeros, laws=laws, symbols=symbols)
    return problem, fit_problem(problem, report, plain)


def used_of(recording: Recording, *owners: Zeros) -> Recording:
    """Return what of a recording is fitted: all of it where its episodes are in groups, else an excerpt."""
    return recording if any(isinstance(one, tuple) for one in owners) else excerpt(recording)


def base_model(recording: Recording, model: ContactModel | None = None) -> ContactModel:
    """Return the paper's model for the recorded fingertip, or that of ``model``.

    Raises:
        RecordingError: its radius is not known.

    """
    if recording.is_material:
        warm = recording.columns.get("temperature")
        usual = float(np.nanmedian(warm)) if warm is not None else math.nan
        return material_model(is_linear=recording.is_step, temperature=usual)
    radius = model.tip_radius if model is not None else recording.fingertip.radius
    if not math.isfinite(radius):
        raise RecordingError(
            f"{recording.name} does not state the radius of the fingertip; "
            "import or record it again with --radius 8mm (from Python: radius=8e-3), or give a model"
        )
    return paper_model(radius)
