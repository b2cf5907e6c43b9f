"""The closed loop: repeatable, and what the controllers do in it is what they promise."""

import math

import numpy as np
import pytest

from validation.controllers.comparison import Trial, run_course, summary, table
from vegrip.trials.candidates import INFORMED, KNOBS, parameters
from vegrip.trials.closed_loop import Course, Result, result_of


@pytest.fixture(scope="module")
def held() -> Course:
    """A constant grip of 6 N per finger through 2.5 s."""
    return run_course(Trial("constant", seed=5, duration=2.5, knob=6.0))


def test_the_same_trial_gives_the_same_bits(held: Course) -> None:
    again = run_course(Trial("constant", seed=5, duration=2.5, knob=6.0))
    assert np.array_equal(again.force, held.force)
    assert np.array_equal(again.margin, held.margin)


def test_a_constant_grip_is_constant(held: Course) -> None:
    _, _, force = held.since(1.5)
    assert np.allclose(force[:, 1:], 6.0, atol=0.1)
    assert np.allclose(force[:, 0], force[:, 1:].sum(axis=1), atol=1e-6)


def test_vegrip_holds_the_object_with_less_than_the_constant_grip(held: Course) -> None:
    light = run_course(Trial("vegrip", seed=5, duration=2.5, knob=0.1))
    assert light.slips == 0
    assert not light.dropped
    assert result_of(light).min_margin > 0.0
    assert result_of(light).mean_grip_force < result_of(held).mean_grip_force


def test_figures_count_from_when_the_hand_carries_the_object() -> None:
    run = Course(
        ("thumb", "index"), slips=2, time=[0.5, 1.0, 1.5], margin=[[0.0, 0.0], [0.5, 0.4], [0.6, 0.3]]
    )
    run.force, run.command = [[9.0, 9.0], [2.0, 2.0], [4.0, 4.0]], [[math.nan] * 2] * 3
    assert result_of(run) == Result(
        2, dropped=False, mean_grip_force=3.0, peak_grip_force=4.0, min_margin=0.3
    )


def test_an_object_that_is_lost_at_once_has_no_mean_force() -> None:
    assert math.isnan(result_of(Course(("thumb",), dropped=True)).mean_grip_force)


def test_trials_are_summed_up_by_controller() -> None:
    good, bad = Result(0, False, 4.0, 6.0, 0.2), Result(3, True, 2.0, 9.0, 0.0)
    s = summary([good, bad])
    assert (s["slips"], s["drops"], s["slip_free"], s["trials"]) == (3, 1, 1, 2)
    assert (s["mean_grip_force"], s["peak_grip_force"], s["min_margin"]) == (3.0, 9.0, 0.0)
    assert table({Trial("vegrip", 0, 1.0, 0.1): good, Trial("cone", 0, 1.0, 0.5): bad}, "x").row_count == 2


@pytest.mark.parametrize("grasp", ["hand", "pinch"])
def test_every_controller_of_the_comparison_is_what_its_name_says(grasp: str) -> None:
    policies = {name: parameters(name, knob).policy for name, knob in KNOBS[grasp].items()}
    margin = {name for name, policy in policies.items() if policy == "margin"}
    assert margin == {"vegrip", "learning", "ellipse", "known"}
    assert parameters("ellipse", 0.15).estimator.surface == "ellipse"
    assert parameters("vegrip", 0.15).estimator.surface == "exact"
    assert policies["elastic"] == "elastic"


def test_only_who_is_told_knows_the_friction_of_the_object() -> None:
    for name, knob in (KNOBS["pinch"] | INFORMED).items():
        one, other = (parameters(name, knob, friction) for friction in (0.5, 0.9))
        assert (one != other) == (name in INFORMED)
    assert parameters("elastic, told", 0.9, 0.5).policy_settings["friction"] == pytest.approx(0.45)
    assert parameters("vegrip, told", 0.15, 0.5).tip.friction == 0.5


def test_the_elastic_surface_holds_the_object_with_a_tenth_more_than_it_believes_is_needed() -> None:
    """Told a friction that is low enough it does not slip, and its force follows the load."""
    run = run_course(Trial("elastic", seed=5, duration=2.0, knob=0.3, grasp="pinch"))
    assert run.slips == 0
    _, _, force = run.since(1.6)
    assert np.all(force[:, 1] > 1.0)
    assert result_of(run).mean_grip_force < 8.0
