"""What a hidden effect leaves that a perfect candidate could gain.

The recording is made a second time without noise, with the effect and without, and the paper's model fitted
as if the noise were there: to the true motion, under the covariance that the errors of the measured one have.
Half the sum of squares that is left more with the effect, in units of the noise, is what a perfect candidate
gains on average; a recording in which that is next to nothing cannot tell, and says nothing of a diagnosis.
"""

import dataclasses

import numpy as np

from validation.diagnosis_trials.cases import Case, make_recording, places_of
from vegrip.errors import VegripError
from vegrip.identification.fit.fitting import base_model
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import Measured, preprocess
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import fit_problem

VISIBLE_NATS = 20.0  # [nats]; a name among thirty candidates pays eight, and five or so for each parameter


def remaining_evidence(case: Case) -> dict[str, float]:
    """Return what each hidden effect by itself leaves of the recording of a case [nats].

    As if nothing were stated wrongly and no zero jumped: a perfect candidate comes after those are found.
    """
    if not case.hidden:
        return {}
    sound = dataclasses.replace(case.faults, noise_stated=1.0, radius_stated=1.0, zero_shift=False)
    case = dataclasses.replace(case, faults=sound)
    plain = left(case, ())
    return {name: left(case, (name,)) - plain for name in case.hidden}


def left(case: Case, only: tuple[str, ...]) -> float:
    """Return what the fitted paper's model leaves with ``only`` these hidden [nats]; inf where none fits."""
    try:
        recording = make_recording(case, only=only)
        places = places_of(case, np.unique(recording.episode).size)
        problem = Problem(base_model(recording), without_noise(case, only), laws=places)
        return 0.5 * float(np.sum(fit_problem(problem).residual ** 2))
    except VegripError:
        return float("inf")


def without_noise(case: Case, only: tuple[str, ...]) -> Measured:
    """Return what a recording would be without noise, its noise stated as it is with it."""
    noisy = make_recording(case, only=only)
    noise = noise_of(noisy)
    quiet = preprocess(make_recording(case, only=only, quiet=True), noise)
    motion = preprocess(noisy, noise).motion
    true = quiet.recording.columns["displacement"]
    return dataclasses.replace(quiet, motion=dataclasses.replace(motion, displacement=true))
