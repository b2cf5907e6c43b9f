"""The other controllers of the demonstration take the force of vegrip, or as few slips."""

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.demo.report import AS_FORCEFUL, AS_SURE, run_other_controllers, sure_knob
from vegrip.messages import ContactEstimate, Estimate
from vegrip.trials.candidates import KNOBS
from vegrip.trials.closed_loop import BELIEF_PERIOD_S, Course, Scenario, result_of, run_scenario


def test_constant_grip_and_cone_run_as_tuned_and_with_the_force_of_vegrip() -> None:
    ours = Course(("thumb", "index"), time=[1.0, 2.5], force=[[5.0] * 2] * 2, margin=[[0.5] * 2] * 2)
    found = run_other_controllers(Scenario(3, 2.5, "pinch"), ours)
    assert list(found) == ["constant", "cone", "constant" + AS_FORCEFUL, "cone" + AS_FORCEFUL]
    assert result_of(found["constant"]).mean_grip_force == pytest.approx(8.0, abs=0.1)
    for name in ("constant", "cone"):
        assert result_of(found[name + AS_FORCEFUL]).mean_grip_force == pytest.approx(5.0, rel=0.01)


@pytest.mark.long
def test_the_least_knob_is_found_that_slips_no_more_than_vegrip() -> None:
    """The object of this seed slips at a constant grip of 4 N and does not at 8 N."""
    scenario = Scenario(3, 6.0, "pinch")
    ours = Course(("thumb", "index"), time=[1.0, 6.0], force=[[0.6] * 2] * 2, margin=[[0.5] * 2] * 2)
    found = run_other_controllers(scenario, ours)
    assert found["constant" + AS_FORCEFUL].dropped or found["constant" + AS_FORCEFUL].slips
    for name in ("constant", "cone"):
        sure, tuned = found[name + AS_SURE], found[name]
        assert not sure.slips
        assert not sure.dropped
        assert result_of(sure).mean_grip_force < result_of(tuned).mean_grip_force
        knob = sure_knob(name, scenario, 0, KNOBS["pinch"][name])
        assert knob is not None
        fewer = run_scenario(scenario, name, 0.9 * knob)
        assert fewer.slips or fewer.dropped


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
