"""Differences of times are exact up to 146 years, and stay there for clocks that jump anywhere in 64 bits."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.estimator.elapsed import bounded_time, elapsed_time, step_time

MOST = 2**62  # [ns]
times = st.integers(-(2**63), 2**63 - 1)


@given(later=times, earlier=times)
def test_a_difference_is_exact_or_146_years_within_a_nanosecond(later: int, earlier: int) -> None:
    exact, found = later - earlier, elapsed_time(later, earlier)
    assert found == exact or abs(exact) >= MOST - 1
    assert abs(found - min(max(exact, -MOST), MOST)) <= 1
    assert abs(found) <= MOST


@pytest.mark.parametrize(
    ("later", "earlier", "elapsed"),
    [
        (0, MOST + 1, -MOST),
        (MOST + 1, 0, MOST),
        (MOST - 2, 0, MOST - 2),
        (0, MOST - 2, 2 - MOST),
        (2**63 - 1, -(2**63), MOST),
        (-(2**63), 2**63 - 1, -MOST),
        (7, 10, -3),
    ],
)
def test_what_lies_farther_apart_is_146_years_apart(later: int, earlier: int, elapsed: int) -> None:
    assert elapsed_time(later, earlier) == elapsed


@pytest.mark.parametrize(
    ("time", "bounded"), [(9 * 10**18 + 1, 9 * 10**18), (-(10**19), -9 * 10**18), (5, 5)]
)
def test_a_time_leaves_room_for_a_setting(time: int, bounded: int) -> None:
    assert bounded_time(time) == bounded


@pytest.mark.parametrize(
    ("later", "earlier", "step"),
    [(7_000_000, 5_000_000, 0.002), (5, 7, 0.0), (99_000_000, 0, 0.099), (2**63 - 1, -(2**63), 0.1)],
)
def test_a_step_counts_from_nothing_to_a_tenth_of_a_second(later: int, earlier: int, step: float) -> None:
    assert step_time(later, earlier) == pytest.approx(step)
