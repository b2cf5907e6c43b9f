"""A node that begins with a finger that holds something: the force that is there, until it knows better."""

from collections.abc import Callable

import numpy as np
import pytest

from vegrip.grip.controller import GripController
from vegrip.grip.node import GraspForce
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import FingertipState, ForceCommand
from vegrip.model import paper_model

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


@pytest.mark.parametrize("seconds", [0.3, 1.0, 10.0])
def test_a_finger_that_returns_after_a_silence_goes_on_with_the_force_that_is_there(seconds: float) -> None:
    settings = ControlSettings(thumb="", limits=LimitSettings(max_force=80.0))
    hand = GripController(("pad",), model=paper_model(9e-3), settings=settings)
    rng, force, before = np.random.default_rng(1), 20.0, 0.0
    for i in range(round((6.0 + seconds) * 500)):
        stamp = round(i * 2e6)
        noise = 0.01 * rng.standard_normal(3)
        state = FingertipState(stamp, "pad", i, force + noise[0], noise[1], noise[2] - 4.9)
        silent = 4.0 < i / 500 < 4.0 + seconds
        commanded = hand.step([] if silent else [state], stamp)
        force += 0.04 * (commanded[0].normal_force - force) if commanded else 0.0
        if i == 1999:
            before = force
        assert i <= 2000 or 0.9 * before < force < 1.1 * before


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
