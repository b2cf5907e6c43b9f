"""The force-controlled drives against a spring."""

import numpy as np
import pytest

from tests.virtual.build import body_of, tips_of
from vegrip.virtual import kernels
from vegrip.virtual.settings import ActuatorSettings

DT = 1e-3
SPRING = 2000.0  # [N/m]


def run(settings: ActuatorSettings, wanted: float, duration: float, tips: kernels.Records | None = None):
    """Press springs with two drives; return the forces over time (steps, 2), and the drives."""
    body, tips = body_of(settings, step=DT), tips_of(2, target=np.nan) if tips is None else tips
    history = []
    for _ in range(round(duration / DT)):
        tips["force"], tips["wanted"] = np.maximum(SPRING * tips["position"], 0.0), wanted
        for i in range(2):
            kernels.move_drive(body[0], tips[i], SPRING)
        history.append(SPRING * tips["position"])
    return np.array(history), tips


def test_force_is_reached_within_the_stiction() -> None:
    forces, _ = run(ActuatorSettings(stiction=0.02), 3.0, 2.0)
    assert forces[-1] == pytest.approx(3.0 - 0.02, abs=1e-3)


def test_force_loop_is_first_order_with_the_stated_bandwidth() -> None:
    forces, _ = run(ActuatorSettings(bandwidth=5.0, stiction=0.0, force_rate=1e5, speed=10.0), 1.0, 0.5)
    after_one_time_constant = forces[round(1.0 / (2.0 * np.pi * 5.0) / DT) - 1, 0]
    assert after_one_time_constant == pytest.approx(1.0 - np.exp(-1.0), abs=0.02)


def test_force_never_rises_faster_than_the_rate_limit() -> None:
    forces, _ = run(ActuatorSettings(force_rate=10.0, stiction=0.0, bandwidth=100.0), 5.0, 1.0)
    assert np.diff(forces[:, 0]).max() <= 10.0 * DT * (1.0 + 1e-9)
    assert forces[-1, 0] == pytest.approx(5.0, rel=1e-3)


def test_motion_is_limited_in_speed() -> None:
    settings = ActuatorSettings(speed=1e-3, force_rate=1e5)
    forces, _ = run(settings, 15.0, 0.2)
    assert np.diff(forces[:, 0]).max() <= SPRING * 1e-3 * DT * (1.0 + 1e-9)


def test_without_a_command_the_position_is_held() -> None:
    _, drives = run(ActuatorSettings(), 3.0, 1.0)
    before = drives["position"].copy()
    run(ActuatorSettings(), np.nan, 1.0, drives)
    assert np.array_equal(drives["position"], before)


def test_a_command_after_a_hold_starts_from_the_present_force() -> None:
    settings = ActuatorSettings(stiction=0.0, force_rate=10.0)
    _, drives = run(settings, 3.0, 2.0)
    run(settings, np.nan, 0.5, drives)
    forces, _ = run(settings, 1.0, 0.1, drives)
    assert forces[0, 0] > 2.9
    assert forces[-1, 0] > 1.9  # ten newtons per second, not a jump to the new value


@pytest.mark.parametrize("wanted", [50.0, -5.0])
def test_forces_outside_the_range_are_held_inside(wanted) -> None:
    forces, _ = run(ActuatorSettings(force_limit=4.0, stiction=0.0), wanted, 2.0)
    assert forces[-1, 0] == pytest.approx(min(max(wanted, 0.0), 4.0), abs=1e-6)


def share(first: float, *others: float) -> list[float]:
    """Return the forces of the opposed fingers."""
    tips = tips_of(1 + len(others))
    kernels.share_forces(tips, np.array([first, *others]))
    return tips["wanted"][1:].tolist()


def test_first_finger_can_raise_but_never_lower_the_others() -> None:
    assert share(2.0, 1.0, 3.0) == [1.0, 3.0]
    assert share(np.nan, 1.0, 3.0) == [1.0, 3.0]
    assert share(8.0, 1.0, 3.0) == pytest.approx([2.0, 6.0])
    assert share(8.0, 0.0, 0.0) == pytest.approx([4.0, 4.0])


def test_a_finger_without_command_takes_no_share() -> None:
    assert share(6.0, 2.0, np.nan) == pytest.approx([6.0, np.nan], nan_ok=True)
    assert np.isnan(share(6.0, np.nan, np.nan)).all()
