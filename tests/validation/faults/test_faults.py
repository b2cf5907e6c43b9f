"""Every fault of the table does what the table says: seen in time, over in time, and the grip never worse."""

import pytest

from validation.faults import table
from validation.faults.frame_faults import Loss
from validation.faults.run import run, undisturbed
from validation.faults.soak import soak
from validation.faults.system_faults import Killed
from validation.faults.testbed import SAMPLING, STATE_RATE_HZ, Scene
from vegrip.messages import Condition
from vegrip.transport.canbus.traffic import TrafficPlan, forecast_traffic

ALIKE = {
    "1 % of all states lost for 10 ms",
    "1 % of all states lost for 100 ms",
    "1 % of all states lost for 1 s",
    "10 % of all states lost for 10 ms",
    "10 % of all states lost for 100 ms",
    "10 % of all states lost for 1 s",
    "100 % of all states lost for 10 ms",
    "normal force stuck at 0 N",
    "normal force stuck at 10 N",
    "normal force NaN",
    "sensor clock jumps 10 s ahead",
    "CPU of the gripping node starved for 0.08 s",
    "a node babbles an identifier below all of ours",
}
"""Of which a harder one of the same kind runs always."""


def as_parameter(case):
    marks = [pytest.mark.long] if case.slow or case.name in ALIKE else []
    return pytest.param(case, id=case.name, marks=marks)


@pytest.mark.parametrize("case", [as_parameter(case) for case in table.CASES])
def test_a_fault_never_makes_the_grip_worse_and_is_seen_and_over_in_time(case):
    assert run(case).complaints() == []


def test_the_undisturbed_hand_holds_with_a_margin_and_lowers_its_grip():
    """Otherwise the cases would show nothing."""
    course = undisturbed(4.0)
    settled = [
        force for time, force in zip(course.time, course.force, strict=True) if time > table.FAULT_BEGIN_S
    ]
    assert 1.0 < settled[-1][0] < 4.0
    assert all(c is Condition.OK for conditions in course.condition[100:] for c in conditions)


def test_a_fault_that_does_harm_is_found():
    """A node that lets go because it is dead and never comes back must not pass."""

    class NeverBack(Killed):
        def end(self, scene):
            scene.hand_node.commands.clear()

    case = table.Case("never back", NeverBack, 0.5, frozenset({Condition.MISSING}), detection=0.02)
    complaints = run(case).complaints()
    assert any("over after None" in complaint for complaint in complaints)


@pytest.mark.parametrize("begin", [1.5, 2.3, 4.0])
def test_a_node_takes_over_what_is_held_whenever_it_is_killed(begin):
    """What its first sample tells is chance; at these times it asks for 9 N to 12.6 N."""
    scene = Scene()
    scene.run_until(begin)
    fault = Killed()
    fault.begin(scene)
    scene.run_until(begin + 0.3)
    held = max(scene.course.force[-1])
    fault.end(scene)
    scene.run_until(begin + 1.3)
    assert (
        max(max(forces) for forces in scene.course.force[round((begin + 0.3) / SAMPLING) :])
        < 1.2 * held + 0.4
    )
    assert scene.hand_node.hand.slips == 0


def test_a_scene_runs_the_same_twice():
    def forces():
        scene = Scene()
        scene.run_until(1.0)
        Loss(0.5).begin(scene)
        scene.run_until(1.5)
        return scene.course.force

    assert forces() == forces()


def test_the_bus_is_as_busy_as_foreseen():
    """The load of hand and node on the simulated bus, against that of ``vegrip bus-load``."""
    scene = Scene()
    scene.run_until(3.0)
    plan = TrafficPlan(fingers=2, rate=STATE_RATE_HZ, report_rate=50.0, health_rate=5.0, status_rate=1.0)
    told = forecast_traffic(plan)
    assert scene.bus.load() == pytest.approx(told.load, rel=0.07)
    assert scene.bus.load() < told.worst_load


@pytest.mark.slow
def test_a_whole_hand_rides_out_the_loss_of_all_states():
    scene = Scene("hand")
    scene.run_until(2.0)
    held = dict(zip(scene.fingers, scene.course.force[-1], strict=True))
    fault = Loss(1.0)
    fault.begin(scene)
    scene.run_until(3.0)
    now = dict(zip(scene.fingers, scene.course.force[-1], strict=True))
    assert all(now[finger] >= 0.97 * held[finger] for finger in held)
    fault.end(scene)
    scene.run_until(3.5)
    assert set(scene.course.condition[-1]) == {Condition.OK}
    assert scene.hand_node.hand.slips == 0


@pytest.mark.long
def test_nothing_grows_in_a_short_soak():
    """The hour is ``make soak``."""
    done = soak(20.0, seed=1)
    assert not done.dropped
    assert done.slips == 0
    assert done.lost == 0
    assert done.objects < 3000, "one for each state would be 4000"
    assert done.memory < 8_000_000
