"""Probing: whose friction is counted on a little more, and when."""

import math

import pytest

from vegrip.grip.friction_belief import begin_belief, believed_variance, expect_finger
from vegrip.grip.friction_probe import (
    PROBE_NEED,
    PROBE_REACH,
    PROBE_SHIFT,
    PROBE_SINCE_SLIP,
    PROBE_SIZE,
    PROBE_STILL,
    begin_probing,
    probe_friction,
    watch_load,
)

DT = 0.002  # [s]
LAG = 0.5  # standard deviations
NOISE = 0.005  # [N]


@pytest.fixture
def grasp() -> list[float]:
    """A thumb that little is needed of and two fingers that decide; the first is known less well."""
    q = [0.0] * PROBE_SIZE
    begin_belief(q, 3, 0.03, 0.08)
    for i, std in enumerate((0.10, 0.15, 0.12)):
        expect_finger(q, i, math.log(0.7), std, 0.08)
    begin_probing(q, 2.0, 0.6, 0.2, 0.06, 0.2, 0.05, 0.5, 2.0)
    q[PROBE_SINCE_SLIP] = 10.0
    q[PROBE_NEED], q[PROBE_NEED + 1], q[PROBE_NEED + 2] = 1.0, 1.0, 1.0
    for i in range(3):
        q[PROBE_STILL + i] = 10.0
    return q


def hold(q: list[float], seconds: float) -> None:
    for _ in range(round(seconds / DT)):
        for i in range(3):
            probe_friction(q, q, i, DT, LAG)


def follow(q: list[float], rate: float, seconds: float) -> float:
    """Let the load of the first finger grow by ``rate`` [1/s]; return for how long it was still [s]."""
    for j in range(round(seconds / DT)):
        watch_load(q, 0, DT, math.exp(rate * j * DT), NOISE, touching=True)
    return q[PROBE_STILL]


def test_the_finger_that_is_least_known_of_those_that_decide_is_probed_alone(grasp: list[float]) -> None:
    hold(grasp, 0.1)
    assert grasp[PROBE_SHIFT + 1] == pytest.approx(0.06)
    assert grasp[PROBE_SHIFT + 2] == 0.0


def test_a_finger_that_is_probed_as_far_as_may_be_does_not_keep_the_next_one_waiting(
    grasp: list[float],
) -> None:
    hold(grasp, 1.0)
    most = (LAG + grasp[PROBE_REACH]) * math.sqrt(believed_variance(grasp, 1))
    assert grasp[PROBE_SHIFT + 1] == pytest.approx(most)
    assert 0.1 < grasp[PROBE_SHIFT + 2] < 0.6


def test_a_load_that_changes_slowly_does_not_keep_a_finger_from_being_probed(grasp: list[float]) -> None:
    assert follow(grasp, -0.4, 2.0) > 1.5


def test_a_load_that_changes_fast_does(grasp: list[float]) -> None:
    follow(grasp, 0.0, 1.0)
    assert follow(grasp, 3.0, 0.2) < 0.1
