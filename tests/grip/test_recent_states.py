"""What a finger has felt of late, in order, and none of it a message before somebody asks."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vegrip.grip.background_diagnosis import KeptStates
from vegrip.messages import FingertipState


@given(count=st.integers(0, 8), after=st.integers(-1, 9))
def test_those_after_a_stamp_are_the_last_ones_in_order(count: int, after: int) -> None:
    numbers = np.arange(count)
    kept = KeptStates("thumb", 10 * numbers, numbers, numbers[:, None] + np.append(np.arange(9.0), 0.0))
    expected = [FingertipState(10 * i, "thumb", i, *(float(i + j) for j in range(9))) for i in range(count)]
    assert list(kept) == expected
    assert kept.after(10 * after) == expected[max(after + 1, 0) :]
