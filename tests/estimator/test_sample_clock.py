"""Order and age of the samples of one estimator."""

import math

import pytest

from vegrip.estimator.sample_clock import MemoryClock, SampleClock, Turn
from vegrip.estimator.settings import EstimatorSettings
from vegrip.grip.layout import FingerLayout
from vegrip.grip.memory import FingerMemory
from vegrip.messages import FingertipState

MS = 1_000_000


def at(milliseconds):
    return FingertipState(milliseconds * MS, "thumb", milliseconds)


@pytest.fixture
def clock():
    return SampleClock(EstimatorSettings(recovery=3, longest_gap=0.25))


def take(clock, sample, *, informs=True):
    assert clock.turn(sample) is Turn.NEXT
    clock.take(sample, informs=informs)


def test_stamps_that_advance_are_next_and_their_spacing_is_in_seconds(clock):
    assert clock.since_last(at(5)) == -1.0, "there is none before the first"
    take(clock, at(5))
    assert clock.since_last(at(7)) == pytest.approx(2e-3)
    take(clock, at(7))
    assert clock.seq == 2
    assert clock.is_trusted


def test_a_sample_that_is_behind_is_not_trusted_until_the_next(clock):
    take(clock, at(5))
    assert clock.turn(at(5)) is Turn.BEHIND
    assert clock.turn(at(4)) is Turn.BEHIND
    assert not clock.is_trusted
    assert clock.offered == at(4)
    assert clock.taken == at(5)
    take(clock, at(6))
    assert clock.is_trusted


def test_refusals_count_and_only_those_in_a_row_start_the_clock_anew(clock):
    take(clock, at(5))
    assert not clock.refuse()
    assert not clock.refuse()
    take(clock, at(6))
    assert [clock.refuse() for _ in range(3)] == [False, False, True]
    assert clock.refused == 5


def test_a_clock_that_starts_anew_leaves_a_gap_longer_than_the_longest(clock):
    take(clock, at(5000))
    clock.follow(at(10))
    assert 0.25 < clock.since_last(at(10)) < 0.2501
    assert clock.age(at(10)) == clock.since_last(at(10))


def test_the_first_sample_after_a_kept_memory_follows_an_unknown_gap(clock):
    clock.resume()
    assert clock.turn(at(10)) is Turn.RESUMED
    clock.follow(at(10))
    assert 0.25 < clock.since_last(at(10)) < 0.2501
    clock.take(at(10), informs=True)
    assert clock.turn(at(11)) is Turn.NEXT


def test_age_is_that_of_the_last_sample_that_informed(clock):
    assert clock.age(at(0)) == math.inf
    take(clock, at(5))
    take(clock, at(9), informs=False)
    assert clock.age(at(9)) == pytest.approx(4e-3)


def test_going_back_and_taking_again_counts_each_sample_once(clock):
    for t in (5, 6, 8, 9):
        take(clock, at(t))
    assert clock.turn(at(7)) is Turn.BEHIND
    clock.rewind(at(6), 2)
    for t in (7, 8, 9):
        clock.take(at(t), informs=True)
    assert clock.seq == 5
    assert clock.taken == at(9)


def test_the_step_of_a_finger_gets_the_clock_and_tells_of_it(clock):
    take(clock, at(5))
    clock.refuse()
    memory = FingerMemory(FingerLayout(10))
    clock.write_to(memory)
    told = MemoryClock(memory, "tip")
    assert (told.taken.stamp, told.seq, told.is_trusted, told.refused) == (at(5).stamp, 1, True, 1)
    assert told.age(at(6)) == clock.age(at(6))
