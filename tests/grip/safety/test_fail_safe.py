"""The fail-safe: hold, then ramp; never down."""

from hypothesis import given
from hypothesis import strategies as st

from tests.grip.stages import FailSafe
from vegrip.grip.safety import FailSafeSettings
from vegrip.messages import Reason

SETTINGS = FailSafeSettings(force=5.0, hold_time=0.2, ramp_rate=10.0)


def ride(held: float, steps: int, dt: float = 0.01) -> list[tuple[float, Reason]]:
    fail_safe, course = FailSafe(SETTINGS), []
    for _ in range(steps):
        held, reason = fail_safe.command(held, dt, Reason.INPUT_HOLD)
        course.append((held, reason))
    return course


def test_the_last_safe_command_is_held_and_then_ramps_to_the_fail_safe_grip() -> None:
    course = ride(2.0, 100)
    assert course[:20] == [(2.0, Reason.INPUT_HOLD)] * 20
    assert course[21][1] == Reason.FAIL_SAFE
    assert abs(course[30][0] - (2.0 + 11 * 0.1)) < 1e-9  # eleven steps of 10 N/s
    assert course[-1][0] == 5.0


@given(held=st.floats(0.0, 50.0), dts=st.lists(st.floats(0.0, 1.0), max_size=50))
def test_a_fault_never_lowers_the_grip(held: float, dts: list[float]) -> None:
    fail_safe = FailSafe(SETTINGS)
    for dt in dts:
        force, _ = fail_safe.command(held, dt, Reason.INPUT_HOLD)
        assert held <= force <= max(held, 5.0)
        held = force


def test_a_second_fault_is_held_anew() -> None:
    fail_safe = FailSafe(SETTINGS)
    for _ in range(50):
        fail_safe.command(2.0, 0.01, Reason.INPUT_HOLD)
    fail_safe.recovered()
    assert not fail_safe.active
    assert fail_safe.command(2.0, 0.01, Reason.UNTRUSTED) == (2.0, Reason.UNTRUSTED)
