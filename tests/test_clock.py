from hypothesis import given
from hypothesis import strategies as st

from vegrip.clock import NS, SimulatedClock, WallClock


@given(st.lists(st.integers(min_value=-NS, max_value=NS), max_size=50))
def test_the_simulated_clock_never_runs_backwards(deadlines: list[int]) -> None:
    clock = SimulatedClock()
    for deadline in deadlines:
        before = clock.now()
        clock.sleep_until(deadline)
        assert clock.now() == max(before, deadline)


def test_the_wall_clock_does_not_sleep_for_a_deadline_that_has_passed() -> None:
    clock = WallClock()
    start = clock.now()
    clock.sleep_until(start - NS)
    assert clock.now() - start < NS
