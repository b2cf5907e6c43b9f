"""A late slip channel teaches by the load of then, and raises the grip only against a slide that lasts."""

import math

import pytest

from vegrip.grip.felt_slip import begin_felt_slip
from vegrip.grip.friction_belief import begin_belief, expect_finger
from vegrip.grip.friction_onset import begin_onsets, feel_onset
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.late_slip import begin_late_slip, present_slip, recall_load

DELAY = 0.02


def late(delay: float = DELAY) -> GraspMemory:
    q = GraspMemory()
    begin_felt_slip(q, 1e-3, delay)
    begin_late_slip(q)
    return q


@pytest.mark.parametrize("dt", [0.0005, 0.002, 0.005, 0.013])
def test_the_load_that_is_recalled_is_that_of_a_delay_ago_at_any_rate(dt: float) -> None:
    q, then = late(), math.nan
    for j in range(round(0.2 / dt)):
        then = recall_load(q, 0, dt, 1.0 + j * dt)
    now = 1.0 + (round(0.2 / dt) - 1) * dt
    assert now - then == pytest.approx(DELAY, abs=1.5 * dt + 0.0026)


def test_without_delay_the_load_is_that_of_now() -> None:
    assert recall_load(late(0.0), 3, 0.002, 0.4) == 0.4


def test_a_load_that_was_not_known_then_is_not_known_now() -> None:
    q = late()
    assert math.isnan(recall_load(q, 0, 0.002, 0.5))
    for _ in range(20):
        recall_load(q, 0, 0.002, math.nan)
    assert math.isnan(recall_load(q, 0, 0.002, 0.5))
    assert present_slip(q, 0, 1.0) == 1.0


def test_a_slide_is_over_where_the_load_has_fallen_far_below_that_of_then() -> None:
    q = late()
    for _ in range(20):
        recall_load(q, 0, 0.002, 0.5)
    assert present_slip(q, 0, 1.0) == 1.0
    recall_load(q, 0, 0.002, 0.405)
    assert present_slip(q, 0, 1.0) == 1.0
    recall_load(q, 0, 0.002, 0.395)
    assert present_slip(q, 0, 1.0) == 0.0
    assert present_slip(q, 1, 1.0) == 1.0, "another finger"
    assert math.isnan(present_slip(q, 0, math.nan)), "what is not sensed stays so"
    for _ in range(20):  # it goes on although the load is as low as it was a delay ago: that is no old slide
        recall_load(q, 0, 0.002, 0.39)
    assert present_slip(q, 0, 1.0) == 1.0


def test_a_late_onset_teaches_the_friction_at_which_it_slid_and_not_the_load_of_a_grip_that_has_grown() -> (
    None
):
    g = late()
    begin_belief(g, 1, 0.03, 0.08)
    expect_finger(g, 0, math.log(0.7), 0.3, 0.08)
    begin_onsets(g, 0.05, 0.08)
    g.probe.shift[0] = 0.1  # it is being let go of: its slip is no surprise
    for _ in range(100):
        feel_onset(g, 0, 0.002, recall_load(g, 0, 0.002, 0.5), 0.02, 0.0, 0.0)
    for _ in range(3):
        feel_onset(g, 0, 0.002, recall_load(g, 0, 0.002, 0.25), 0.02, 1.0, 5e-3)
    assert math.exp(g.belief.mean[0]) == pytest.approx(0.5, rel=0.03)
