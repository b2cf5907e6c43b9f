"""The virtual hand as a node: pure code driven without a bus."""

import tomllib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest
from vegrip.nodes import grasp_force
from vegrip.nodes.virtual_hand import VirtualHandNode, build

from validation.controllers.node_loop import NodeLoop
from vegrip.errors import ConfigError
from vegrip.messages import FingertipState, ForceCommand, Message, ModelHealth, Reason
from vegrip.runtime import NodeContext

TICK = 2_000_000  # [ns]
START = 10**12


def active(**settings) -> VirtualHandNode:
    node = build({"disturbed": False, **settings}, NodeContext("virtual_hand"))
    node.configure()
    node.activate()
    return node


def command(finger: str, force: float, now: int, life: int = 100_000_000) -> ForceCommand:
    return ForceCommand(now, finger, 0, force, 0.0, Reason.HOLD, now + life)


def run(node: VirtualHandNode, ticks: int, now: int = START) -> tuple[list[FingertipState], int]:
    states: list[FingertipState] = []
    for _ in range(ticks):
        states += [m for m in node.on_tick(now) if isinstance(m, FingertipState)]
        now += TICK
    return states, now


def test_states_of_all_fingers_are_published_with_stamps_of_the_clock() -> None:
    states, now = run(active(), 501)
    assert len(states) == 5 * 500
    assert {s.finger for s in states} == {"thumb", "index", "middle", "ring", "little"}
    assert all(START < s.stamp <= now for s in states)
    assert states[-1].stamp == START + 500 * TICK


def test_commands_are_obeyed_until_they_expire() -> None:
    node = active()
    _, now = run(node, 500)
    for finger in node.hand.fingers[1:]:
        assert not list(node.on_message(command(finger, 2.0, now, life=10**9), now))
    _, now = run(node, 490, now)
    assert node.hand.truth("ring").normal_force == pytest.approx(2.0, abs=0.05)
    position = node.hand.tips["position"].copy()
    run(node, 500, now + 10**9)
    assert node.hand.tips["position"] == pytest.approx(position, abs=1e-12)


@pytest.mark.parametrize(
    ("finger", "force", "life", "reason"),
    [
        ("tail", 1.0, 10**8, "unknown finger"),
        ("index", float("nan"), 10**8, "no usable force"),
        ("index", -1.0, 10**8, "no usable force"),
        ("index", 1.0, -1, "expired"),
    ],
)
def test_commands_that_cannot_be_obeyed_are_counted(finger, force, life, reason) -> None:
    node = active()
    node.on_message(command(finger, force, START, life), START)
    assert node.refused == {reason: 1}
    assert not node.commands


def test_a_late_loop_simulates_a_bounded_time() -> None:
    node = active()
    node.on_tick(START)
    states = list(node.on_tick(START + 10 * 10**9))
    assert node.hand.time == pytest.approx(0.05)
    assert states[-1].stamp == START + 10 * 10**9


def test_it_ends_after_its_duration() -> None:
    node = active(duration=0.1)
    run(node, 40)
    assert not node.finished
    run(node, 20, START + 40 * TICK)
    assert node.finished


def test_activation_begins_anew() -> None:
    node = active()
    first, _ = run(node, 100)
    node.deactivate()
    node.activate()
    again, _ = run(node, 100)
    assert repr(first) == repr(again)  # NaN differs from NaN


def test_fingers_are_those_of_the_bus() -> None:
    two = NodeContext("hand", fingers=("thumb", "index"))
    assert build({}, two).hand.fingers == ("thumb", "index")
    with pytest.raises(ConfigError, match=r"hand\.fingers"):
        build({}, NodeContext("hand", fingers=("left", "right")))
    jaws = {"hand": {"fingers": ["left", "right"], "x": [0.0, 0.0], "y": [0.0, 0.0]}}
    assert build(jaws, NodeContext("hand", fingers=("left", "right"))).hand.fingers == ("left", "right")
    with pytest.raises(ConfigError, match="the bus knows"):
        build(jaws, two)


def test_disturbances_are_those_of_their_seed() -> None:
    node = active(disturbed=True, disturbance_seed=4, duration=30.0)
    other = VirtualHandNode("other", replace(node.parameters, disturbance_seed=5))
    assert node.hand.events
    assert node.hand.events != other.hand.events


def test_a_running_hand_refuses_to_become_another_one() -> None:
    node = active()
    with pytest.raises(ConfigError, match="deactivate"):
        node.parameters = replace(node.parameters, seed=5)
    node.deactivate()
    node.parameters = replace(node.parameters, seed=5)
    node.activate()
    assert node.hand.soft.tips != active().hand.soft.tips


class Listening(NodeLoop):
    """A loop that keeps what the node says of its model."""

    misfits: set[tuple[str, str]]

    def take(self, answers: Iterable[Message]) -> None:
        answers = list(answers)
        self.misfits |= {(m.finger, m.channel) for m in answers if isinstance(m, ModelHealth) and m.channel}
        super().take(answers)


@pytest.mark.parametrize("relaxes_slowly", [False, True])
def test_the_model_of_the_demonstration_explains_its_own_hand_from_the_start_unless_something_is_hidden(
    relaxes_slowly: bool,
) -> None:
    launch = tomllib.loads((Path(__file__).parents[2] / "launch" / "demo.toml").read_text())
    context = NodeContext("node", "", tuple(launch["fingers"]), 0.002)
    grasp, hand = (node["parameters"] for node in launch["node"][:2])
    if relaxes_slowly:
        hand["hand"] = {"tip": {"amplitudes": [0.2, 0.1], "rates": [3.1, 0.15]}}
    loop = Listening(build(hand, context).hand, grasp_force.build(grasp, context))
    loop.misfits = set()
    loop.run(8.0)
    fingers = {finger for finger, _ in loop.misfits}
    assert not fingers if not relaxes_slowly else len(fingers) >= 3
    assert {channel for _, channel in loop.misfits} <= {"normal_force"}
