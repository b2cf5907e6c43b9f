"""The node in its loop answers frames compiled, and everything else goes on as before."""

import logging
from collections import Counter
from dataclasses import replace
from typing import Any

import pytest

from validation.faults.testbed import Scene
from vegrip.grip.node import GraspForce
from vegrip.messages import Condition, Lifecycle, Message
from vegrip.runtime.telemetry import Direction, Telemetry

UNTIL = 1.2  # [s]
FACING = {"thumb": {"normal": [0.0, 0.0, 1.0]}, "index": {"normal": [0.0, 0.0, -1.0]}}


class Listener:
    """A sink that wants messages or does not."""

    def __init__(self) -> None:
        self.wanted = False
        self.counts: Counter[str] = Counter()
        self.got: list[tuple[Message, Direction]] = []

    def takes(self, message: Message, direction: Direction) -> bool:  # noqa: ARG002
        return True

    def wants(self, kind: type[Message], owner: str, direction: Direction) -> bool:  # noqa: ARG002
        return True

    def count(self, message: Message, direction: Direction) -> None:
        self.tally(type(message), "", direction)

    def tally(self, kind: type[Message], owner: str, direction: Direction) -> None:  # noqa: ARG002
        self.counts[f"{kind.__name__} {direction.value}"] += 1

    def listen(self) -> None: ...

    def publish(self, messages: Any) -> None:
        self.got += messages

    def close(self) -> None: ...


def frames(scene: Scene) -> int:
    """How many frames ran compiled."""
    path = scene.grip.runner.frame_path
    return 0 if path is None else path.frames


def test_a_hand_is_held_with_the_same_forces_on_both_ways() -> None:
    compiled, messages = Scene("hand", sender_time=True), Scene("hand", sender_time=True)
    messages.grip.endpoint.intercept = None
    for scene in (compiled, messages):
        scene.run_until(UNTIL)
    assert frames(messages) == 0
    assert frames(compiled) > 1000
    assert compiled.course.force == messages.course.force
    assert compiled.course.command == messages.course.command


def test_the_loop_says_which_way_states_go(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, "vegrip"):
        runner = Scene("pinch", sender_time=True).grip.runner
    assert "states are answered by the compiled step (" in caplog.text
    assert runner.path_taken.endswith("finger by finger")
    node = runner.managed.node
    assert isinstance(node, GraspForce)
    node.cleanup()
    node.parameters = replace(node.parameters, policy="cone")
    node.configure()
    assert runner.path_taken.endswith("finger by finger")
    node.cleanup()
    node.parameters = replace(node.parameters, contacts=FACING)
    node.configure()
    assert runner.path_taken.endswith("in halves: the places of the contacts are given")
    node.run_compiled({})
    assert runner.path_taken.endswith("by the hand's clock (estimate_clock)")


def test_counts_and_status_are_those_of_messages() -> None:
    scene = Scene("pinch", sender_time=True)
    listener = Listener()
    scene.grip.runner._telemetry = telemetry = Telemetry(listener)
    assert scene.grip.runner.frame_path is not None
    scene.grip.runner.frame_path._telemetry = telemetry
    scene.run_until(UNTIL)
    statistics = scene.grip.runner.statistics
    assert frames(scene) > 400
    assert statistics.states == listener.counts["FingertipState in"]
    assert statistics.commands == listener.counts["ForceCommand out"]
    assert statistics.commands == scene.hand.runner.statistics.commands_received
    status = scene.grip.runner.status
    assert status is not None
    assert not status.rejected
    assert status.rate_in > 300.0


def test_a_status_counts_what_the_step_has_lost_and_the_step_goes_on() -> None:
    scene = Scene("pinch", sender_time=True)
    scene.run_until(0.6)
    node = scene.node
    assert isinstance(node, GraspForce)
    first, *_ = fingers = list(node.compiled_fingers.values())
    first.memory["LINE_LOST"] += 3
    assert scene.grip.runner._rejected()["lost"] == 3
    assert all(finger.numbers.is_on_line for finger in fingers)
    scene.run_until(UNTIL)
    assert scene.grip.runner.status is not None
    assert scene.grip.runner.status.rejected == {"lost": 3}


def shown(scene: Scene) -> list[str]:
    """Return what a reader of all telemetry hears between 0.6 and 0.9 s, as text: there NaN equals NaN."""
    scene.run_until(0.6)
    listener = Listener()
    listener.wanted = True
    telemetry = Telemetry(listener)
    assert scene.grip.runner.frame_path is not None
    scene.grip.runner._telemetry = scene.grip.runner.frame_path._telemetry = telemetry
    scene.run_until(0.9)
    telemetry.drain()
    return list(map(repr, listener.got))


def test_a_reader_of_the_messages_gets_the_same_and_frames_still_run_compiled() -> None:
    compiled, messages = Scene("pinch", sender_time=True), Scene("pinch", sender_time=True)
    messages.grip.endpoint.intercept = None
    compiled.run_until(0.6)
    before = frames(compiled)
    assert shown(compiled) == shown(messages)
    assert frames(compiled) - before == 2 * 60  # of two fingers at 200 Hz, 0.3 s


def test_reports_go_on() -> None:
    scene = Scene("pinch", sender_time=True)
    received: Counter[str] = Counter()
    on_message = scene.hand.node.on_message

    def count(message: Message, now: int) -> Any:
        received[type(message).__name__] += 1
        return on_message(message, now)

    scene.hand.node.on_message = count  # type: ignore[method-assign]
    scene.run_until(UNTIL)
    fingers = len(scene.fingers)
    assert frames(scene) > 400
    assert received["SlipMargin"] == received["ContactEstimate"] > 0.7 * fingers * UNTIL / 0.025
    assert received["ModelHealth"] >= fingers * int(UNTIL / 0.2) - fingers


def test_after_a_fault_of_the_node_commands_are_held_and_numbered_on() -> None:
    scene = Scene("pinch", sender_time=True)
    scene.run_until(1.0)
    node = scene.node
    assert node is not None
    reports, held = node.reports, scene.course.command[-1]

    def broken(name: str, now: int) -> Any:
        raise ValueError(name)

    node.reports = broken  # type: ignore[method-assign]
    scene.run_until(1.3)
    assert scene.grip.runner.state is Lifecycle.INACTIVE
    assert all(now >= before - 1e-6 for now, before in zip(scene.course.command[-1], held, strict=True))
    node.reports = reports  # type: ignore[method-assign]
    scene.run_until(2.6)
    assert scene.grip.runner.state is Lifecycle.ACTIVE
    assert all(scene.course.obeyed[150:]), "a command was not there in time, or refused"
    assert not scene.hand.endpoint.rejected
    assert scene.course.condition[-1] == (Condition.OK,) * len(scene.fingers)
    before = frames(scene)
    scene.run_until(2.8)
    assert frames(scene) > before


def test_activated_anew_it_numbers_its_commands_on() -> None:
    scene = Scene("pinch", sender_time=True)
    scene.run_until(0.6)
    before = frames(scene)
    for transition in ("deactivate", "activate"):
        scene.grip.runner.change(transition)
    scene.run_until(1.0)
    assert frames(scene) > before + 100
    assert scene.hand.runner.statistics.commands_received == scene.grip.runner.statistics.commands


@pytest.mark.parametrize("name", ["limits.min_force", "grip.wanted_margin"])
def test_a_parameter_set_in_the_loop_counts(name: str) -> None:
    from vegrip.runtime.lifecycle import with_value

    scene = Scene("pinch", sender_time=True)
    scene.run_until(0.8)
    node = scene.node
    assert node is not None
    before = scene.course.command[-1]
    value = 9.0 if name == "limits.min_force" else 0.6
    node.parameters = with_value(node.parameters, name, value, True, "grip")
    scene.run_until(1.6)
    after = scene.course.command[-1]
    assert all(b > a + 0.3 for a, b in zip(before, after, strict=True))
    assert frames(scene) > 500
