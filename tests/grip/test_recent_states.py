"""States kept as messages and as rows are one past, in order, and none is made that nobody asks for."""

from copy import copy

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vegrip.grip.recent_states import KeptStates, RecentStates
from vegrip.messages import FingertipState

MOST = 12


def state(i: int) -> FingertipState:
    return FingertipState(10 * i, "thumb", i, *(float(i + j) for j in range(9)))


def rows(first: int, count: int) -> KeptStates:
    numbers = np.arange(first, first + count)
    values = numbers[:, None] + np.append(np.arange(9.0), 0.0)
    return KeptStates("thumb", 10 * numbers, numbers, values)


@given(st.lists(st.integers(0, 8), max_size=12), st.integers(0, 15))
def test_messages_and_rows_are_one_past_of_which_the_last_are_kept(groups: list[int], count: int) -> None:
    past, expected = RecentStates(MOST), list[FingertipState]()
    for size in groups:
        first = len(expected)
        expected += [state(first + i) for i in range(max(size, 1))]
        if size:
            past.extend(rows(first, size))
        else:
            past.append(state(first))
    kept = list(past)
    assert len(past) == len(kept) <= MOST + 8
    assert kept == expected[len(expected) - len(kept) :]
    assert len(kept) >= min(len(expected), MOST)
    assert past.last(count) == kept[max(len(kept) - count, 0) :]
    stamp = 10 * (len(expected) - count)
    assert past.after(stamp) == [one for one in kept if one.stamp > stamp]


def test_a_copy_does_not_change_with_what_comes_later() -> None:
    past = RecentStates(MOST)
    past.extend(rows(0, 3))
    before = copy(past)
    past.append(state(3))
    assert list(before) == [state(i) for i in range(3)]
