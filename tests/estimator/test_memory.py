"""The numbers of an estimator by their names, alone and in the memory of a finger."""

import math

import pytest

from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.estimator.memory import FingerMemory
from vegrip.grip.layout import FingerLayout
from vegrip.messages import FingertipState
from vegrip.model import paper_model


@pytest.fixture
def estimator():
    return ContactEstimator(paper_model(8e-3), SensorNoise())


@pytest.fixture
def memory(estimator):
    return FingerMemory(FingerLayout(estimator.layout, estimator.settings.late, history=5, is_shared=True))


def test_every_number_has_one_name(memory):
    layout = memory.layout
    for places, first, end in (
        (layout.reals, layout.filter.size, layout.n_reals),
        (layout.wholes, 0, layout.n_wholes),
    ):
        named = [place for name, place in places.items() if not name.endswith("0")]
        assert len(named) == len(set(named))
        assert min(named) >= first
        assert max(places.values()) < end


def test_a_value_that_is_not_measured_leaves_what_effects_feel_as_it_was(estimator):
    felt = estimator.named.section("EXOGENOUS")
    estimator.update(
        FingertipState(0, "thumb", 0, 1.0, 1.5, 0.0, 2.5, temperature=31.0, slip=1.0, slip_speed=0.2)
    )
    assert felt.tolist()[:4] == [31.0, 1.5, 2.5, 0.2]
    before = felt.tolist()
    estimator.update(FingertipState(1, "thumb", 1, 1.0, math.inf, math.nan, math.nan, temperature=math.nan))
    assert felt.tolist() == [*before[:4], math.inf if math.isinf(felt[4]) else before[4], before[5]]


def test_the_noise_of_a_slip_speed_is_no_sliding_while_the_contact_sticks(estimator):
    estimator.update(FingertipState(0, "thumb", 0, 1.0, 1.0, slip=0.0, slip_speed=0.2))
    assert estimator.named.section("EXOGENOUS")[3] == 0.0


def test_what_it_knows_moves_with_it_and_is_reset_where_it_lies(estimator, memory):
    estimator.update(FingertipState(10**9, "thumb", 0, 1.0, displacement=1e-3))
    before, known = estimator.memory.tobytes(), repr(estimator.contact_estimate())
    memory["STATE_DISPLACEMENT"] = 7.0
    estimator.mount(memory, "thumb")
    assert memory["STATE_DISPLACEMENT"] == 7.0, "the state of the finger stays"
    assert (estimator.memory.tobytes(), repr(estimator.contact_estimate())) == (before, known)
    assert memory.section("ESTIMATOR").tobytes() == before
    estimator.reset()
    assert memory.section("ESTIMATOR").tobytes() != before
    assert memory["SAMPLE_SEQ"] == 0
    assert memory["CLOCK_RECOVERY"] == estimator.settings.recovery


def test_zeros_walk_in_a_moment_as_far_as_disturbances_of_their_spread_and_time_constant():
    """The variance that a stationary disturbance changes by within dt is 2 s^2 (1 - exp(-dt / tau))."""
    noise = SensorNoise(normal_force=0.02, displacement=1e-5)
    times = {"displacement_drift_time": 4.0, "force_drift_time": 7.0}
    settings = EstimatorSettings(displacement_drift=0.3, force_drift=0.2, **times)
    estimator = ContactEstimator(paper_model(8e-3), noise, settings)
    first, last = estimator.layout.places()["DRIFT"]
    walks = estimator.memory[first:last].tolist()[-2:]
    for rate, spread, time in zip(walks, (0.3 * 1e-5, 0.2 * 0.02), times.values(), strict=True):
        moment = 1e-6 * time
        grown = -2.0 * spread**2 * math.expm1(-moment / time)
        assert rate * moment == pytest.approx(grown, rel=1e-5, abs=0.0)
