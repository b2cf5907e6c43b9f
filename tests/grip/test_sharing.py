"""How the fingers of a node share a grasp: confidence of each, internal forces of all, faults of some."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.grip.controller import GripController
from vegrip.grip.node import GraspForce
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.model import paper_model

MakeNode = Callable[..., GraspForce]
MakeState = Callable[..., FingertipState]
PERIOD = 2_000_000  # [ns]
ANGLES = {"a": 0.0, "b": 2.0 * math.pi / 3.0, "c": 4.0 * math.pi / 3.0}
BALL = {
    name: {
        "place": (-0.03 * math.cos(angle), -0.03 * math.sin(angle), 0.0),
        "normal": (math.cos(angle), math.sin(angle), 0.0),
    }
    for name, angle in ANGLES.items()
}
LOADS = {"a": 2.4, "b": 1.0, "c": 0.5}


def run(
    node: GraspForce, state: MakeState, steps: range, silent: tuple[str, ...] = ()
) -> dict[str, ForceCommand]:
    last = {}
    for i in steps:
        for finger, load in LOADS.items():
            if finger in silent:
                continue
            for message in node.on_message(state(i, finger, tangential_force_x=load), i * PERIOD):
                if isinstance(message, ForceCommand):
                    last[message.finger] = message
        for message in node.on_tick(i * PERIOD):
            if isinstance(message, ForceCommand):
                last[message.finger] = message
    return last


@pytest.fixture
def around() -> ControlSettings:
    return ControlSettings(contacts=BALL)


def test_three_fingers_around_an_object_press_alike(
    make_node: MakeNode, state: MakeState, around: ControlSettings
) -> None:
    last = run(make_node(tuple(BALL), around), state, range(1, 1500))
    need = LOADS["a"] / (0.8 * (1.0 - around.grip.wanted_margin))
    forces = [command.normal_force for command in last.values()]
    assert forces == pytest.approx([need] * 3, rel=0.05)


def test_a_silent_finger_holds_and_the_others_go_on(
    make_node: MakeNode, state: MakeState, around: ControlSettings
) -> None:
    node = make_node(tuple(BALL), around)
    before = run(node, state, range(1, 1500))
    after = run(node, state, range(1500, 3000), silent=("b",))
    assert after["b"].reason in (Reason.INPUT_HOLD, Reason.FAIL_SAFE)
    for name in BALL:
        assert after[name].normal_force >= 0.98 * before[name].normal_force


def test_a_finger_that_was_never_heard_does_not_hinder_the_others(
    make_node: MakeNode, state: MakeState, around: ControlSettings
) -> None:
    last = run(make_node(tuple(BALL), around), state, range(1, 1500), silent=("c",))
    assert last.keys() == {"a", "b"}
    for name, command in last.items():
        assert command.normal_force >= LOADS[name] / (0.8 * (1.0 - around.grip.wanted_margin)) * 0.999
        assert command.normal_force <= around.limits.max_force


def test_every_finger_is_asked_at_the_confidence_the_grasp_needs(
    make_node: MakeNode, state: MakeState
) -> None:
    grip = GripSettings(probability=0.99)
    node = make_node(tuple(BALL), ControlSettings(grip=grip))
    run(node, state, range(1, 4))
    wanted = 0.99
    for finger in node.fingers.values():
        assert finger.estimator.confidence == wanted  # type: ignore[attr-defined]


def test_the_wanted_probability_can_be_changed_while_it_runs(make_node: MakeNode, state: MakeState) -> None:
    node = make_node(tuple(BALL))
    run(node, state, range(1, 4))
    node.parameters = dataclasses.replace(node.parameters, grip=GripSettings(probability=0.999))
    run(node, state, range(4, 8))
    assert node.fingers["a"].estimator.confidence == 0.999  # type: ignore[attr-defined]


def test_contacts_of_fingers_the_hand_does_not_have_are_refused(
    make_node: MakeNode, around: ControlSettings
) -> None:
    with pytest.raises(ConfigError, match="'contacts' has b, c; the fingers are a, thumb"):
        make_node(("a", "thumb"), around)


def test_the_parameter_of_the_correlation_is_refused_with_a_sentence() -> None:
    with pytest.raises(ConfigError, match="correlation"):
        build(ControlSettings, {"grip": {"correlation": 0.5}}, "grasp_force")


@pytest.mark.parametrize("others", [1, 2, 4])
def test_a_thumb_is_lowered_as_the_fingers_are_that_press_against_it(others: int) -> None:
    """Each finger is lowered at its rate; at this rate the thumb alone would go on pressing."""
    names = ("thumb", *(f"finger {i}" for i in range(others)))
    settings = ControlSettings(limits=LimitSettings(max_force=40.0))
    hand = GripController(names, model=paper_model(9e-3), settings=settings)
    forces, rng = dict.fromkeys(names, 3.0), np.random.default_rng(1)
    first = most = 0.0
    for k in range(3500):
        load = 0.6 if k < 1500 else max(0.6 - (k - 1500) / 300, 0.1)
        states = []
        for name in names:
            x = load * (others if name == "thumb" else 1)
            x, y, force = np.array([x, 0.0, forces[name]]) + 0.01 * rng.standard_normal(3)
            states.append(FingertipState(k * PERIOD, name, k, force, x, y, 0.0))
        for command in hand.step(states, k * PERIOD):
            forces[command.finger] = command.normal_force
        if k == 1500:
            first = forces["thumb"]
        if k > 1500:
            most = max(most, abs(forces["thumb"] - sum(forces[name] for name in names[1:])))
    assert forces["thumb"] < 0.25 * first
    assert most < 0.05 * first
