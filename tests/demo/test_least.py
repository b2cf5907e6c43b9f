"""The least grip force of a course is that of the compiled trial, and others take the force of vegrip."""

import math

import numpy as np
import pytest

from validation.controllers.comparison import Trial, run_course
from vegrip.clock import NS
from vegrip.demo.others import (
    AS_FORCEFUL,
    course_of,
    force_over_least,
    least_grip_force,
    run_other_controllers,
)
from vegrip.messages import ContactEstimate, Estimate
from vegrip.trials.closed_loop import BELIEF_PERIOD_S, Course
from vegrip.trials.fronts import QualityTrial, run_quality_trial
from vegrip.trials.result import result_of
from vegrip.trials.scenario import Scenario


def test_the_least_force_of_a_course_is_that_of_the_compiled_trial() -> None:
    run = run_quality_trial(QualityTrial("constant", 3, 2.5, 8.0, "pinch"))
    least = run.truth["least"]
    expected = np.maximum(least[:, 0], least[:, 1:].sum(axis=1))
    held = run.time > 0.7
    assert np.allclose(least_grip_force(course_of(run))[held], expected[held], rtol=1e-9)


def test_the_uncompiled_loop_keeps_what_the_least_force_needs() -> None:
    slow = run_course(Trial("constant", 3, 1.6, 8.0, "pinch"))
    fast = course_of(run_quality_trial(QualityTrial("constant", 3, 1.6, 8.0, "pinch")))
    late = np.array(slow.time) > 1.0
    assert np.allclose(least_grip_force(slow)[late], least_grip_force(fast)[late], rtol=0.02)
    assert force_over_least(slow, 1.0) == pytest.approx(force_over_least(fast, 1.0), rel=0.01)


def test_what_was_never_held_has_no_ratio() -> None:
    assert math.isnan(force_over_least(Course(("thumb",), dropped=True), 1.0))


def test_constant_grip_and_cone_run_as_tuned_and_with_the_force_of_vegrip() -> None:
    ours = Course(("thumb", "index"), time=[1.0, 2.5], force=[[5.0] * 2] * 2, margin=[[0.5] * 2] * 2)
    found = run_other_controllers(Scenario(3, 2.5, "pinch"), ours)
    assert list(found) == ["constant", "cone", "constant" + AS_FORCEFUL, "cone" + AS_FORCEFUL]
    assert result_of(found["constant"]).mean_grip_force == pytest.approx(8.0, abs=0.1)
    for name in ("constant", "cone"):
        assert result_of(found[name + AS_FORCEFUL]).mean_grip_force == pytest.approx(5.0, rel=0.01)


def test_beliefs_of_the_first_finger_are_kept_once_in_a_while() -> None:
    course, mu = Course(("thumb", "index")), Estimate(0.7, 0.2, True, 0.0)
    for sample in range(100):
        for finger in course.fingers:
            time = 0.002 * sample
            contact = ContactEstimate(
                round(time * NS), finger, sample, in_contact=True, friction_coefficient=mu
            )
            course.believe(contact, time)
    assert [time for time, _, _ in course.friction] == pytest.approx(
        np.arange(0.0, 0.2, BELIEF_PERIOD_S).tolist(), abs=0.003
    )
    assert {belief[1:] for belief in course.friction} == {(0.7, 0.2)}
