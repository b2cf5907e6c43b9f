"""Probing: whose friction is counted on a little more, and when."""

import math

import pytest

from vegrip.grip.friction_belief import begin_belief, believed_variance, expect_finger
from vegrip.grip.friction_probe import (
    begin_probing,
    feel_slip,
    is_quiet,
    probe_friction,
    watch_load,
)
from vegrip.grip.grasp_memory import GraspMemory

DT = 0.002  # [s]
LAG = 0.5  # standard deviations
NOISE = 0.005  # [N]


@pytest.fixture
def grasp() -> GraspMemory:
    """A thumb that little is needed of and two fingers that decide; the first is known less well."""
    q = GraspMemory()
    begin_belief(q, 3, 0.03, 0.08)
    for i, std in enumerate((0.10, 0.15, 0.12)):
        expect_finger(q, i, math.log(0.7), std, 0.08)
    begin_probing(q, 2.0, 0.6, 0.2, 0.06, 0.2, 0.05, 0.5, 2.0)
    q.probe.since_slip = 10.0
    q.probe.need[0], q.probe.need[1], q.probe.need[2] = 1.0, 1.0, 1.0
    for i in range(3):
        q.probe.still[i] = 10.0
    return q


def hold(q: GraspMemory, seconds: float) -> None:
    for _ in range(round(seconds / DT)):
        for i in range(3):
            probe_friction(q, i, DT, LAG)


def follow(q: GraspMemory, rate: float, seconds: float) -> float:
    """Let the load of the first finger grow by ``rate`` [1/s]; return for how long it was still [s]."""
    for j in range(round(seconds / DT)):
        watch_load(q, 0, DT, math.exp(rate * j * DT), NOISE, touching=True)
    return q.probe.still[0]


def test_the_finger_that_is_least_known_of_those_that_decide_is_probed_alone(grasp: GraspMemory) -> None:
    hold(grasp, 0.1)
    assert grasp.probe.shift[1] == pytest.approx(0.06)
    assert grasp.probe.shift[2] == 0.0


def test_a_finger_that_is_probed_as_far_as_may_be_does_not_keep_the_next_one_waiting(
    grasp: GraspMemory,
) -> None:
    hold(grasp, 1.0)
    most = (LAG + grasp.probe.reach) * math.sqrt(believed_variance(grasp, 1))
    assert grasp.probe.shift[1] == pytest.approx(most)
    assert 0.1 < grasp.probe.shift[2] < 0.6


def test_a_load_that_changes_slowly_does_not_keep_a_finger_from_being_probed(grasp: GraspMemory) -> None:
    assert follow(grasp, -0.4, 2.0) > 1.5


def test_a_load_that_changes_fast_does(grasp: GraspMemory) -> None:
    follow(grasp, 0.0, 1.0)
    assert follow(grasp, 3.0, 0.2) < 0.1


@pytest.mark.parametrize(
    ("still", "since", "quiet"),
    [
        ((0.2, 0.2, -1.0), 0.5, True),
        ((0.19, 0.2, 0.2), 0.5, False),
        ((0.2, 0.0, 0.2), 0.5, False),
        ((0.2, 0.2, 0.2), 0.49, False),
    ],
)
def test_it_is_quiet_a_while_after_the_last_change_of_any_load_and_the_last_slip(
    grasp: GraspMemory, still: tuple[float, ...], since: float, quiet: bool
) -> None:
    grasp.probe.since_slip = since
    for i in range(3):
        grasp.probe.still[i] = still[i]
    assert is_quiet(grasp, 3) == quiet


def test_the_time_since_a_slip_is_counted_once_for_all_fingers(grasp: GraspMemory) -> None:
    feel_slip(grasp, DT, 3, slipping=True)
    for _ in range(30):
        feel_slip(grasp, DT, 3, slipping=False)
    assert grasp.probe.since_slip == pytest.approx(10.0 * DT)


@pytest.mark.parametrize(("change", "counts"), [(0.0595, False), (0.0605, True)])
def test_a_load_changes_by_a_twentieth_and_two_deviations(
    grasp: GraspMemory, change: float, counts: bool
) -> None:
    for _ in range(500):
        watch_load(grasp, 0, DT, 1.0, NOISE, touching=True)
    grasp.probe.load[0] = 1.0
    grasp.probe.still[0] = 5.0
    for _ in range(1000):  # so quickly that the load from which changes are counted does not follow
        watch_load(grasp, 0, 1e-7, 1.0, NOISE, touching=True)
    watch_load(grasp, 0, 1e-6, 1.0 + change * 1e4, NOISE, touching=True)  # smoothed over 10 ms
    assert (grasp.probe.still[0] == 0.0) == counts


def test_the_loads_are_followed_within_their_times(grasp: GraspMemory) -> None:
    watch_load(grasp, 0, DT, 1.0, 9.0, touching=False)
    watch_load(grasp, 0, DT, 1.0, 9.0, touching=True)
    for _ in range(10):
        watch_load(grasp, 0, 0.001, 2.0, 9.0, touching=True)
    assert grasp.probe.load[0] < 1.1
    assert grasp.probe.smooth[0] == pytest.approx(2.0 - 1.0 / math.e)
    for _ in range(200):
        watch_load(grasp, 0, 0.001, 2.0, 9.0, touching=True)
    told = grasp.probe.load[0]  # the lag of 10 ms, then of 100 ms
    expected = 2.0 - (0.1 * math.exp(-0.21 / 0.1) - 0.01 * math.exp(-0.21 / 0.01)) / 0.09
    assert told == pytest.approx(expected, abs=0.01)


def test_an_unknown_object_is_let_go_of_faster_and_by_all_fingers_and_a_known_finger_is_not(
    grasp: GraspMemory,
) -> None:
    for std, rates in ((0.21, (2.0, 2.0)), (0.19, (0.6, 0.0)), (0.061, (0.6, 0.0)), (0.059, (0.0, 0.0))):
        q = GraspMemory()
        q.array[:] = grasp.array
        begin_belief(q, 3, 0.03, 0.08)
        for i in range(3):
            expect_finger(q, i, math.log(0.7), std - (0.0 if i == 1 else 1e-4), 0.01)
        for i in (1, 2):
            probe_friction(q, i, DT, LAG)
        assert [q.probe.shift[i] for i in (1, 2)] == pytest.approx([rate * DT for rate in rates])


@pytest.mark.parametrize(
    ("thumb", "probed"),
    [(1.9, [False, True, False]), (2.1, [True, False, False]), (2.0, [False, True, False])],
)
def test_those_decide_whose_need_is_larger_the_thumb_or_the_others(
    grasp: GraspMemory, thumb: float, probed: list[bool]
) -> None:
    """Of those that do not, none is waited for."""
    grasp.probe.need[0] = thumb
    if thumb > 2.0:  # the thumb alone, though others are known less
        grasp.probe.need[1] = 1.0
    for i in range(3):
        probe_friction(grasp, i, DT, LAG)
    told = [grasp.probe.shift[i] > 0.0 for i in range(3)]
    assert told[0] == probed[0]
