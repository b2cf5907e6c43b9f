"""What a drive is commanded: a force that it can make, never below the need, and not back and forth."""

import itertools
import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.clock import NS
from vegrip.grip.safety.drive import DriveLimits
from vegrip.transport.hands.drive_steps import Commanded, least_force_sentence, next_force, step_above

COARSE = DriveLimits(resolution=0.84, rate=50.0, minimum=20.0, maximum=235.0, hysteresis=0.5)
FINE = DriveLimits(resolution=0.01, rate=200.0, minimum=0.5, maximum=40.0)
DRIVES = st.builds(
    lambda step, least, span, dead: DriveLimits(step, 0.0, 0.0, least, least + max(span, step, dead), dead),
    st.sampled_from([0.0, 0.01, 0.84, 5.0]),
    st.floats(0.0, 30.0),
    st.floats(1.0, 200.0),
    st.sampled_from([0.0, 0.3, 2.0]),
)
PERIOD = NS // 100


def course(drive, needs):
    """Return what the drive is commanded for ``needs`` [N], one each 10 ms."""
    commanded, found = Commanded(), []
    for number, need in enumerate(needs, 1):
        commanded = next_force(drive, commanded, need, number * PERIOD)
        found.append(commanded.force)
    return found


def changes(forces):
    """Return the times [s] at which what is commanded changes."""
    return [number * 0.01 for number in range(1, len(forces)) if forces[number] != forces[number - 1]]


@given(DRIVES, st.lists(st.floats(0.1, 250.0), min_size=1, max_size=80))
def test_what_is_told_can_be_made_and_is_not_below_the_need(drive, needs):
    for need, force in zip(needs, course(drive, needs), strict=True):
        assert drive.minimum <= force <= drive.maximum
        assert force >= min(need * (1 - 1e-6), drive.maximum - drive.resolution)
        if drive.resolution and force not in (drive.minimum, drive.maximum):
            steps = (force - drive.minimum) / drive.resolution
            assert math.isclose(steps, round(steps), abs_tol=1e-6)


@given(DRIVES, st.lists(st.floats(0.1, 250.0), min_size=2, max_size=80))
def test_no_change_is_smaller_than_what_the_drive_follows(drive, needs):
    forces = course(drive, needs)
    for before, after in itertools.pairwise(forces):
        is_end = after > before and after > drive.maximum - max(drive.resolution, drive.hysteresis)
        assert after == before or is_end or abs(after - before) >= drive.hysteresis - 1e-9


@pytest.mark.parametrize("drive", [COARSE, FINE, DriveLimits(hysteresis=1.0), DriveLimits()])
@pytest.mark.parametrize("need", [20.84, 21.0, 24.1, 31.3])
@pytest.mark.parametrize("noise", [0.05, 0.2])
def test_under_a_constant_load_at_most_one_step_changes_in_ten_seconds(drive, need, noise):
    rng = random.Random(f"{need} {noise}")  # noqa: S311
    times = changes(course(drive, [need + rng.uniform(-noise, noise) for _ in range(12_000)]))
    late = [time for time in times if time > 1.0]
    assert all(after - before >= 10.0 - 1e-9 for before, after in itertools.pairwise(late))


def test_a_need_is_rounded_up_and_the_step_itself_is_not():
    assert step_above(COARSE, 3.0) == 20.0
    assert step_above(COARSE, 20.01) == pytest.approx(20.84)
    assert step_above(COARSE, 20.0 + 5 * 0.84) == pytest.approx(24.2)
    assert step_above(COARSE, 300.0) <= 235.0


def test_a_greater_need_is_followed_with_the_next_command_that_the_drive_takes():
    forces = course(COARSE, [25.0] * 100 + [40.0] * 3)
    assert forces[99] < 40.0 <= forces[102]


def test_a_load_that_is_taken_away_is_let_go_of_after_half_a_second_and_a_small_change_after_ten():
    quick = course(COARSE, [40.0] * 200 + [25.0] * 300)
    assert quick[245] >= 40.0
    assert quick[255] < 30.0
    assert 25.0 <= quick[-1] < 26.5
    slow = course(COARSE, [25.0] * 200 + [23.5] * 1100)
    assert slow[1100] >= 25.0
    assert 23.5 <= slow[-1] < 25.0


def test_a_command_leaves_no_sooner_than_the_drive_takes_it():
    times = changes(course(DriveLimits(resolution=0.1, rate=5.0), [20.0 + 0.3 * n for n in range(300)]))
    assert min(after - before for before, after in itertools.pairwise(times)) >= 0.2 - 1e-9


def test_no_force_opens_at_once_and_touch_is_the_least_force():
    assert course(COARSE, [0.3, 25.0, 0.0])[0] == 20.0
    assert course(COARSE, [25.0] * 10 + [0.0])[-1] == 0.0


def test_what_a_gripper_cannot_do_is_said_with_its_ratio():
    said = least_force_sentence(COARSE, 20.0 / 6.0)
    assert said == "the least that this gripper can is 20 N, 6 times what is needed"
    assert least_force_sentence(COARSE, 18.0) == ""
    assert least_force_sentence(DriveLimits(), 1.0) == ""
