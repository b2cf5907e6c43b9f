"""What a finger has felt of late, in order, and none of it a message before somebody asks."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.grip.background_diagnosis import KeptStates
from vegrip.grip.finger_step import NOT_NUMBERS, as_whole
from vegrip.grip.node import GraspForce
from vegrip.messages import FingertipState


@given(count=st.integers(0, 8), after=st.integers(-1, 9))
def test_those_after_a_stamp_are_the_last_ones_in_order(count: int, after: int) -> None:
    numbers = np.arange(count)
    kept = KeptStates("thumb", 10 * numbers, numbers, numbers[:, None] + np.append(np.arange(9.0), 0.0))
    expected = [FingertipState(10 * i, "thumb", i, *(float(i + j) for j in range(9))) for i in range(count)]
    assert list(kept) == expected
    assert kept.after(10 * after) == expected[max(after + 1, 0) :]


def test_a_finger_keeps_two_thousand_states_and_gives_sixty_four_at_once_or_all(
    make_node: Callable[..., GraspForce], state: Callable[..., FingertipState]
) -> None:
    finger = make_node().fingers["index"]
    numbers, memory = finger.numbers, finger.memory

    def note(count: int) -> None:
        """Let this many states have been accepted, the last ones by hand: their numbers count from 0."""
        rows = np.arange(max(count - 2000, 0), count)
        memory.section("HISTORY_SEQ")[rows % 2000] = rows
        memory["TURN_NOTED"] = count

    for first in (0, 64):
        note(first + 63)
        assert numbers.fetch() is None
        note(first + 64)
        assert numbers.fetch().numbers.tolist() == [*range(first, first + 64)]
    note(128 + 999)
    assert not numbers.is_half_full()
    note(128 + 1000)
    assert numbers.is_half_full()
    note(3100)
    assert numbers.past.numbers.tolist() == [*range(1100, 3100)]
    assert numbers.fetch().numbers.tolist() == [*range(1100, 3100)]  # what was not fetched in time is lost
    assert numbers.fetch(everything=True) is None
    finger.answer(state(3100), 2_000_000 * 3100)
    assert numbers.fetch() is None
    assert numbers.fetch(everything=True).numbers.tolist() == [3100]
    assert numbers.past.numbers.tolist() == [*range(1101, 3101)]


LARGEST = 2**63 - 1


@pytest.mark.parametrize(
    ("number", "whole"),
    [
        (7.9, 7), (-3, -3), (LARGEST, LARGEST), (-LARGEST, -LARGEST), (LARGEST + 1, LARGEST),
        (-LARGEST - 1, LARGEST), (10**400, LARGEST), (np.int64(5), 5),
    ],
)  # fmt: skip
def test_a_counter_beyond_64_bits_counts_as_the_largest(number: Any, whole: int) -> None:
    assert as_whole(number) == whole


@pytest.mark.parametrize("number", [None, "3", [3.0], 1j, float("nan"), float("inf")])
def test_what_is_no_counter_raises_what_is_caught(number: object) -> None:
    with pytest.raises(NOT_NUMBERS):
        as_whole(number)
