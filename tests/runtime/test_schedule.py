"""Laws of the schedule."""

from hypothesis import given
from hypothesis import strategies as st

from vegrip.runtime.statistics import Schedule

MS = 1_000_000


@given(start=st.integers(0, 10**15), delays=st.lists(st.integers(0, 20 * MS), max_size=50))
def test_ticks_stay_on_the_grid_however_late_they_are_served(start, delays):
    schedule = Schedule(0.002)
    schedule.start(start)
    for served, delay in enumerate(delays):
        due = schedule.due
        assert schedule.take(due + delay) == delay
        assert (schedule.due - start) % (2 * MS) == 0
        assert schedule.due > due + delay, "a tick in the past would bunch up"
        assert schedule.due - (due + delay) <= 2 * MS, "no tick after now is skipped"
        assert (schedule.due - start) // (2 * MS) == served + 1 + schedule.skipped


def test_a_thousand_punctual_ticks_take_exactly_a_thousand_periods():
    schedule = Schedule(0.001)
    schedule.start(0)
    for _ in range(1000):
        schedule.take(schedule.due + 300)  # always a little late
    assert schedule.due == 1000 * MS
    assert schedule.skipped == 0
