"""One estimator for all tests, and records to run it on."""

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.friction_prior import COULOMB
from vegrip.messages import NAN, ContactEstimate, FingertipState
from vegrip.model import ContactModel, paper_model

R = 8e-3
RATE = 500.0
Record = Callable[..., list[FingertipState]]


@pytest.fixture(scope="session")
def model() -> ContactModel:
    return paper_model(R)


@pytest.fixture(scope="session")
def compiled(model: ContactModel) -> ContactEstimator:
    return ContactEstimator(model, SensorNoise(), EstimatorSettings(friction=COULOMB))


@pytest.fixture
def estimator(compiled: ContactEstimator) -> Iterator[ContactEstimator]:
    compiled.reset()
    yield compiled
    compiled.reset()


def pressed(
    model: ContactModel,
    knots: list[float],
    depths: list[float],
    *,
    share: float = 0.0,
    slip_after: float = math.inf,
    seed: int = 0,
    noise: SensorNoise | None = None,
) -> list[FingertipState]:
    """States of a noisy fingertip that is moved through ``depths`` [m] at ``knots`` [s] under a load.

    ``share`` is the tangential force over mu N; from ``slip_after`` [s] on it is 1 and the finger slides.
    """
    noise = noise if noise is not None else SensorNoise()
    rng = np.random.default_rng(seed)
    t = np.arange(int(knots[-1] * RATE)) / RATE
    delta = np.interp(t, knots, depths)
    contact = model.simulate(t, delta)
    slides = (t >= slip_after) & (contact.normal_force > 0.0)
    limit = contact.friction_coefficient * contact.normal_force
    load = np.where(slides, 1.0, share) * limit
    force = contact.sensed_force + noise.normal_force * rng.standard_normal(t.size)
    displacement = delta + noise.displacement * rng.standard_normal(t.size)
    tangential = load + noise.tangential_force * rng.standard_normal(t.size)
    rows = zip(t, force, tangential, displacement, slides, strict=True)
    return [
        FingertipState(round(s * 1e9), "tip", i, N, f, 0.0, 0.0, d, NAN, float(slip))
        for i, (s, N, f, d, slip) in enumerate(rows)
    ]


@pytest.fixture(scope="session")
def press() -> Record:
    return pressed


@pytest.fixture(scope="session")
def run() -> Callable[[ContactEstimator, list[FingertipState]], ContactEstimate]:
    """Push all states through; give the last estimate."""

    def through(estimator: ContactEstimator, states: list[FingertipState]) -> ContactEstimate:
        for state in states:
            estimate = estimator.update(state)
        return estimate

    return through
