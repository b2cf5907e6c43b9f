"""A node that begins with a finger that holds something: the force that is there, until it knows better."""

from collections.abc import Callable

import pytest

from vegrip.grip.node import GraspForce
from vegrip.grip.settings import ControlSettings
from vegrip.messages import FingertipState, ForceCommand

MakeNode = Callable[..., GraspForce]
MakeState = Callable[..., FingertipState]
ALONE = ControlSettings(thumb="")
UNSURE = 11.0  # [N] asked for
HELD = 3.0  # [N] measured


def asks(node: GraspForce, force: float) -> None:
    """Have the estimator ask for ``force`` [N]."""
    node.fingers["index"].estimator.least_force = lambda *_: force  # type: ignore[method-assign]


def commands(node: GraspForce, states: list[FingertipState]) -> list[float]:
    answers = [message for state in states for message in node.on_message(state, state.stamp)]
    return [message.normal_force for message in answers if isinstance(message, ForceCommand)]


def test_one_unsure_look_at_a_contact_met_in_its_middle_moves_nothing(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node(settings=ALONE)
    asks(node, UNSURE)
    first = commands(node, [state(1)])
    asks(node, 2.0)
    later = commands(node, [state(i) for i in range(2, 140)])
    assert max(first + later) == pytest.approx(HELD, abs=0.01)


def test_an_estimator_that_stays_unsure_is_obeyed_after_the_stated_time(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node(settings=ALONE)
    asks(node, UNSURE)
    forces = commands(node, [state(i) for i in range(1, 300)])
    assert max(forces[:150]) <= ALONE.fail_safe.force
    assert forces[-1] == pytest.approx(UNSURE)


def test_slip_that_is_felt_raises_the_grip_at_once(make_node: MakeNode, state: MakeState) -> None:
    node = make_node(settings=ALONE)
    asks(node, UNSURE)
    believed = ALONE.watchdog.recover_after
    forces = commands(node, [state(i, slip=float(i > believed)) for i in range(1, 100)])
    assert forces[believed] - forces[believed - 1] == pytest.approx(ALONE.limits.raise_rate * 2e-3)
    assert forces[-1] >= UNSURE


def test_the_estimators_of_a_node_that_failed_take_over_what_is_held(
    make_node: MakeNode, state: MakeState
) -> None:
    node = make_node(settings=ALONE)
    before = commands(node, [state(i) for i in range(1, 100)])[-1]
    node.on_fault(state(100).stamp)
    node.deactivate()
    node.activate()
    asks(node, UNSURE)
    assert commands(node, [state(101)]) == [pytest.approx(before)]
