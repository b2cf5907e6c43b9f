"""Disturbances are data: the same for every controller."""

import math

import pytest

from vegrip.virtual.disturbance import (
    NO_BURDEN,
    AddedMass,
    Push,
    Shake,
    SlowLoad,
    Turn,
    Twist,
    Wetting,
    disturbances,
    total,
)

ONE_OF_EACH = [
    Push(1.0, 0.4, 2.0, -1.0),
    Twist(1.0, 0.4, 0.03),
    SlowLoad(1.0, 2.0, 0.5, 1.0),
    Shake(1.0, 2.0, 1.0, 3.0, 0.4),
    AddedMass(1.0, 2.0, 0.2),
    Turn(1.0, 2.0, 1.2),
    Wetting(1.0, 2.0, 0.5),
]


def size(burden) -> float:
    parts = (burden.force_x, burden.force_y, burden.torque, burden.mass, burden.turn, 1.0 - burden.friction)
    return max(map(abs, parts))


@pytest.mark.parametrize("event", ONE_OF_EACH, ids=lambda e: type(e).__name__)
def test_acts_only_in_its_time_and_begins_and_ends_gently(event) -> None:
    end = event.start + event.duration
    assert event.burden(event.start) == event.burden(end) == event.burden(0.5) == NO_BURDEN
    inside = [event.burden(event.start + event.duration * part / 1000) for part in range(1, 1000)]
    assert size(inside[0]) < 0.02 * max(map(size, inside))
    assert size(inside[-1]) < 0.02 * max(map(size, inside))


def test_burdens_add_up() -> None:
    both = total([Push(0.0, 1.0, 2.0, 0.0), Push(0.0, 1.0, 1.0, 3.0)], 0.5)
    assert (both.force_x, both.force_y) == pytest.approx((3.0, 3.0))
    wet = total([Wetting(0.0, 1.0, 0.5), Wetting(0.0, 1.0, 0.5)], 0.5)
    assert wet.friction == pytest.approx(0.25)


def test_nothing_acts_when_nothing_is_due() -> None:
    assert total(ONE_OF_EACH, 0.0) is NO_BURDEN


def test_slow_load_grows_evenly() -> None:
    load = SlowLoad(0.0, 10.0, 4.0, 0.0)
    assert load.burden(2.0).force_x == pytest.approx(1.0)
    assert load.burden(8.0).force_x == pytest.approx(4.0)


def test_same_seed_same_schedule() -> None:
    assert disturbances(7, 30.0) == disturbances(7, 30.0)
    assert disturbances(7, 30.0) != disturbances(8, 30.0)


@pytest.mark.parametrize("seed", range(5))
def test_schedule_lies_inside_its_time_and_scales_with_the_weight(seed) -> None:
    events = disturbances(seed, 20.0, weight=3.0)
    assert len(events) >= 4
    assert all(event.start >= 2.0 and event.start + event.duration <= 20.0 for event in events)
    times = [0.01 * i for i in range(2000)]
    light = [total(events, t) for t in times]
    heavy = [total(disturbances(seed, 20.0, weight=6.0), t) for t in times]
    push = max(math.hypot(b.force_x, b.force_y) for b in light)
    assert max(math.hypot(b.force_x, b.force_y) for b in heavy) == pytest.approx(2.0 * push)


def test_a_longer_schedule_begins_with_the_shorter_one() -> None:
    short, long = disturbances(3, 20.0), disturbances(3, 60.0)
    early = [event for event in long if event.start + event.duration < 20.0 and event.start < 19.5]
    assert list(short) == early
