"""The fail-safe is never down, and anew for each fault; how it ramps: tests/grip/kernels/test_control.py."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.grip.stages import FailSafe
from vegrip.grip.safety import FailSafeSettings
from vegrip.messages import Reason

SETTINGS = FailSafeSettings(force=5.0, hold_time=0.2, ramp_rate=10.0)


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


def test_what_is_held_is_held_for_its_time_and_then_rises_at_the_rate_up_to_the_fail_safe_grip() -> None:
    """Hold for 0.25 s, then 8 N/s up to 5 N; a step lasts 0.125 s."""
    fail_safe = FailSafe(FailSafeSettings(force=5.0, hold_time=0.25, ramp_rate=8.0))
    held, told = 2.0, []
    for _ in range(6):
        held, reason = fail_safe.command(held, 0.125, Reason.INPUT_HOLD)
        told.append((held, reason))
    hold, ramp = Reason.INPUT_HOLD, Reason.FAIL_SAFE
    assert told == [(2.0, hold), (2.0, hold), (3.0, ramp), (4.0, ramp), (5.0, ramp), (5.0, hold)]


@pytest.mark.parametrize(("lowered_from", "held"), [(4.0, 2.8), (2.75, 2.75), (1.0, 2.7)])
def test_at_a_fault_what_was_lowered_to_learn_friction_comes_back_at_the_rate_and_no_further(
    lowered_from: float, held: float
) -> None:
    fail_safe = FailSafe(SETTINGS)
    fail_safe.memory["GRIP_LOWERED_FROM"] = lowered_from
    force, reason = fail_safe.command(2.7, 0.01, Reason.INPUT_HOLD)
    assert (force, reason) == (pytest.approx(held), Reason.INPUT_HOLD)
