"""Two hands that speak as one are told; one hand never is, whatever it does."""

import math
import random
from itertools import chain

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from vegrip.messages import FingertipState
from vegrip.runtime.sender_watch import MOST_FINGERS, TURN_STATES, WINDOW_STATES, SenderWatch

RATE = 200.0  # [Hz]
SIGMA = 0.02  # [N]


def watched(forces, displacements=None):
    watch = SenderWatch()
    for seq, force in enumerate(forces):
        displacement = math.nan if displacements is None else displacements[seq]
        watch.note(FingertipState(seq, "thumb", seq, normal_force=force, displacement=displacement))
    return watch.count


def noise(seed, count=2000):
    chance = random.Random(seed)  # noqa: S311
    return [chance.gauss(0.0, SIGMA) for _ in range(count)]


def in_turn(one, other):
    return list(chain.from_iterable(zip(one, other, strict=True)))


@given(apart=st.floats(10 * SIGMA, 20.0), seed=st.integers(0, 999), level=st.floats(0.0, 20.0))
def test_two_hands_in_turn_are_told_within_the_window_and_as_long_as_they_last(apart, seed, level):
    states = in_turn([level + e for e in noise(seed)], [level + apart + e for e in noise(seed + 1)])
    assert watched(states) >= len(states) - 3 * WINDOW_STATES


@pytest.mark.parametrize("resolution", [0.0, 0.001, 0.1, 1.0])
@example(seed=213, hz=0.375, size=0.3125, step=0.33203125)
@given(
    seed=st.integers(0, 999), hz=st.floats(0.01, RATE / 8), size=st.floats(0.0, 20.0), step=st.floats(-20, 20)
)
def test_one_hand_is_not_told_whatever_it_holds_lifts_or_drops(resolution, seed, hz, size, step):
    forces = [
        5.0 + size * math.sin(2 * math.pi * hz * i / RATE) + step * (i > 1000) + e
        for i, e in enumerate(noise(seed))
    ]
    if resolution:
        forces = [resolution * round(force / resolution) for force in forces]
    assert watched(forces) == 0


@given(seed=st.integers(0, 999), at=st.integers(0, 1999), value=st.floats(-1e6, 1e6))
def test_one_wrong_sample_is_not_told(seed, at, value):
    forces = [5.0 + e for e in noise(seed)]
    forces[at] = value
    assert watched(forces) == 0


def test_constant_values_and_none_at_all_are_not_told():
    assert watched([3.0] * 500) == 0
    assert watched([math.nan] * 500) == 0
    assert watched([math.inf, -math.inf] * 500) == 0


def test_two_hands_are_told_by_their_positions_too():
    places = in_turn([1e-3 + 1e-4 * e for e in noise(1)], [2e-3 + 1e-4 * e for e in noise(2)])
    assert watched([math.nan] * len(places), places) > 0
    assert watched([5.0 + e for e in noise(3, len(places))], places) > 0


def test_made_up_fingers_do_not_make_it_grow():
    watch = SenderWatch()
    for number in range(3000):
        watch.note(FingertipState(number, f"f{number}", 0, normal_force=1.0))
    assert len(watch._fingers) == MOST_FINGERS


def test_one_of_five_fingers_that_is_two_is_told_by_a_look_at_one_after_the_other():
    watch, fingers = SenderWatch(), [f"f{number}" for number in range(5)]
    looked_at = 0
    for seq, (one, other) in enumerate(zip(noise(1, 5000), in_turn(noise(2), noise(3)), strict=False)):
        for name in fingers:
            if watch.has_turn(name):
                looked_at += 1
                apart = 0.5 * (seq % 2) if name == "f3" else 0.0
                watch.note_values(name, 5.0 + one, 1e-3 + 1e-4 * (other + apart))
        if watch.count:
            break
    assert watch.count > 0
    assert seq < 5 * TURN_STATES // len(fingers), "within the time in which each has had its turn"
    assert looked_at <= 0.25 * 5 * (seq + 1)
