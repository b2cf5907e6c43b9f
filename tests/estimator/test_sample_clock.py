"""Order and age of the samples of one estimator."""

import math

import pytest

from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import paper_model

MS = 1_000_000


def at(milliseconds, force=1.0, **values):
    return FingertipState(round(milliseconds * MS), "thumb", 0, force, displacement=1e-3, **values)


@pytest.fixture
def estimator():
    settings = EstimatorSettings(recovery=3, longest_gap=0.25, late=3)
    return ContactEstimator(paper_model(8e-3), SensorNoise(), settings)


def test_a_sample_that_is_refused_leaves_nothing_trusted_until_the_next(estimator):
    for time, is_trusted in ((5, True), (5, False), (4, False), (6, True)):
        told = estimator.update(at(time))
        assert told.stamp == time * MS
        assert told.normal_force.valid == is_trusted
    assert (told.seq, estimator.refused) == (2, 2)


def test_only_refusals_in_a_row_start_the_clock_anew(estimator):
    times = (5, 5, 5, 6, 6, 6)
    assert [estimator.update(at(time)).seq for time in times] == [1, 1, 1, 2, 2, 2]
    assert estimator.update(at(6)).seq == 3
    assert estimator.refused == 5


def test_a_clock_that_starts_anew_leaves_a_gap_longer_than_the_longest(estimator):
    estimator.update(at(5000))
    for _ in range(3):
        told = estimator.update(at(10, math.nan))
    assert told.seq == 2
    assert estimator.contact_estimate().normal_force.age == 0.0
    estimator.update(FingertipState(11 * MS, "thumb", 0, slip=0.0))
    assert estimator.contact_estimate().normal_force.age == pytest.approx(1e-3)


def test_the_first_sample_after_a_kept_memory_follows_an_unknown_gap(estimator):
    estimator.update(at(5))
    estimator.resume(estimator.memory)
    assert not estimator.contact_estimate().normal_force.valid
    told = estimator.update(FingertipState(10 * MS, "thumb", 0, slip=0.0)).normal_force
    assert (told.age, told.valid) == (pytest.approx(0.25, abs=1e-6), False)
    assert estimator.update(at(11)).normal_force.age == 0.0
    assert estimator.refused == 0


def test_age_is_that_of_the_last_sample_that_informed(estimator):
    assert estimator.update(FingertipState(0, "thumb", 0)).normal_force.age == math.inf
    estimator.update(at(5))
    assert estimator.update(FingertipState(9 * MS, "thumb", 0, slip=0.0)).normal_force.age == pytest.approx(
        4e-3
    )


def test_the_first_sample_must_measure_force_or_displacement(estimator):
    told = estimator.update(FingertipState(MS, "thumb", 0, tangential_force_x=1.0))
    assert (told.stamp, told.seq) == (MS, 0)
    assert not told.normal_force.valid


def test_going_back_and_taking_again_counts_each_sample_once(estimator):
    for time in (5, 6, 8, 9, 7):
        told = estimator.update(at(time, slip=float(time == 7)))
    assert (told.seq, estimator.late) == (5, 1)
    assert estimator.slip_margin().stamp == 9 * MS
    state = estimator.named.section("STATE")
    assert state[6] == 1.0, "the state stays the present one"


@pytest.mark.parametrize("stamp", [2**63 - 1, -(2**63), 2**80, -(2**80)])
def test_stamps_beyond_all_clocks_do_no_harm(estimator, stamp):
    for step in (0, 1, 0, -1, 5, 2**70):
        estimator.update(FingertipState(stamp + step, "thumb", 0, 1.0, displacement=1e-3))
    assert math.isfinite(estimator.update(at(5)).normal_force.value)


@pytest.mark.parametrize(
    ("stamp", "told"),
    [
        (2**63 - 2, 2**63 - 2),
        (2**63 - 1, 2**63 - 1),
        (2**80, 2**63 - 1),
        (2 - 2**63, 2 - 2**63),
        (1 - 2**63, 1 - 2**63),
        (-(2**80), 1 - 2**63),
    ],
)
def test_a_stamp_is_told_as_it_came_or_as_the_farthest_that_has_an_opposite(estimator, stamp, told):
    assert estimator.update(FingertipState(stamp, "thumb", 0, 1.0, displacement=1e-3)).stamp == told
