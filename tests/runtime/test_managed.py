"""Commands are held while a node cannot speak, whatever fails in it."""

import logging

import pytest

from vegrip.clock import NS
from vegrip.messages import ForceCommand, Lifecycle, NodeStatus, Reason
from vegrip.runtime.managed import CommandHold, ManagedNode
from vegrip.runtime.node import NodeBase

LIFE = 100_000_000  # [ns]
LOG = logging.getLogger("test")


def command(finger: str = "thumb", seq: int = 1, force: float = 2.0, stamp: int = NS) -> ForceCommand:
    return ForceCommand(stamp, finger, seq, force, 0.5, Reason.RAISE, stamp + LIFE)


class Node(NodeBase):
    """Does what it is told, or fails at it."""

    def __init__(self, fails: tuple[str, ...] = (), standing: tuple[ForceCommand, ...] = ()) -> None:
        super().__init__("node")
        self.fails, self.standing = set(fails), standing
        self.broken: list[str] = []

    def do(self, what: str) -> None:
        if what in self.fails:
            raise ZeroDivisionError(what)

    def activate(self) -> None:
        self.do("activate")

    def deactivate(self) -> None:
        self.do("deactivate")

    def cleanup(self) -> None:
        self.do("cleanup")

    def on_tick(self, now):
        self.do("tick")
        return [command(stamp=now)]

    def on_message(self, message, now):
        yield command(stamp=now, seq=message.seq)
        self.do("message")
        yield message

    def on_broken(self, finger: str, _now: int) -> None:
        self.broken.append(finger)
        self.do("broken")

    def standing_commands(self):
        self.do("standing")
        return self.standing


def managed(node: NodeBase, *transitions: str) -> ManagedNode:
    one = ManagedNode(node, LOG)
    for transition in transitions:
        one.change(transition)
    return one


def test_a_held_command_is_repeated_from_half_its_life_on_with_the_next_number_and_the_same_force() -> None:
    hold = CommandHold()
    hold.remembered(command())
    assert hold.commands(NS + LIFE // 2 - 1) == []
    (again,) = hold.commands(NS + LIFE // 2)
    assert (again.normal_force, again.seq, again.reason) == (2.0, 2, Reason.INPUT_HOLD)
    assert (again.adjustment, again.expires - again.stamp) == (0.0, LIFE)
    assert hold.commands(NS + LIFE // 2) == []


def test_the_number_of_a_command_rises_whoever_has_counted() -> None:
    hold = CommandHold()
    assert [hold.remembered(command(seq=seq)).seq for seq in (5, 3, 9)] == [5, 6, 9]
    hold.take_over([command(seq=8, force=1.0), command("index", seq=4)])
    assert hold.numbers() == {"thumb": 9, "index": 4}
    hold.take_over([command(seq=12, force=1.0)])
    assert hold.numbers() == {"thumb": 12, "index": 4}
    status = NodeStatus(NS, "node", 1, Lifecycle.ACTIVE)
    assert hold.remembered(status) is status


def test_no_more_than_64_commands_are_held_and_those_are_kept_up() -> None:
    hold = CommandHold()
    fingers = [f"finger{number}" for number in range(65)]
    for finger in fingers:
        hold.remembered(command(finger))
    hold.take_over([command(fingers[64], seq=2)])
    assert list(hold.numbers()) == fingers[:64]
    assert hold.remembered(command(fingers[64])) == command(fingers[64]), "sent, though not held"
    hold.remembered(command(fingers[0], seq=7))
    assert hold.numbers()[fingers[0]] == 7


def test_a_node_that_is_not_active_answers_nothing_and_hears_of_nothing_broken() -> None:
    node = Node()
    one = managed(node, "configure")
    one.on_broken("thumb", NS)
    assert list(one.on_message(command(), NS)) == []
    assert list(one.on_tick(NS)) == []
    assert node.broken == []


def test_a_node_that_is_deactivated_between_two_answers_gives_no_more() -> None:
    one = managed(Node(), "configure", "activate")
    answers = one.on_message(command(seq=3), NS)
    assert next(answers).seq == 3
    one.change("deactivate")
    assert list(answers) == []


@pytest.mark.parametrize("fails", ["message", "tick", "broken"])
def test_whatever_raises_puts_the_node_on_hold_with_its_command_until_it_can_be_active_again(fails) -> None:
    node = Node((fails,))
    one = managed(node, "configure", "activate")
    one.on_tick(NS) if fails != "tick" else list(one.on_message(command(), NS))
    meet = {
        "message": lambda: list(one.on_message(command(seq=4), NS)),
        "tick": lambda: one.on_tick(NS),
        "broken": lambda: one.on_broken("thumb", NS),
    }
    meet[fails]()
    assert (one.on_hold, one.state, one.faults.total()) == (True, Lifecycle.INACTIVE, 1)
    (held,) = one.on_tick(NS + LIFE // 2)
    assert (held.normal_force, held.reason) == (2.0, Reason.INPUT_HOLD)
    node.fails = {"activate"}
    assert [one.reason for one in one.on_tick(2 * NS)] == [Reason.INPUT_HOLD]
    assert one.on_hold
    node.fails = set()
    assert one.on_tick(4 * NS) == ()
    assert (one.on_hold, one.state) == (False, Lifecycle.ACTIVE)


def test_what_stands_when_a_node_fails_is_held_and_what_cannot_be_told_does_not_matter() -> None:
    told = managed(Node(standing=(command("index", seq=6),)), "configure", "activate")
    told.fail(ZeroDivisionError(), NS)
    assert [(one.finger, one.seq) for one in told.on_tick(NS + LIFE)] == [("index", 7)]
    silent = managed(Node(("standing",)), "configure", "activate")
    list(silent.on_tick(NS))
    silent.fail(ZeroDivisionError(), NS)
    silent.fail(ZeroDivisionError(), NS)
    assert silent.numbers_sent() == {"thumb": 1}
    assert silent.faults["fault ZeroDivisionError"] == 2


def test_a_node_without_an_ear_for_broken_states_stays_active() -> None:
    one = managed(NodeBase("deaf"), "configure", "activate")
    one.on_broken("thumb", NS)
    assert one.state is Lifecycle.ACTIVE


@pytest.mark.parametrize(
    ("transitions", "failed"),
    [((), 0), (("configure",), 1), (("configure", "activate"), 2)],
)
def test_a_shutdown_comes_to_its_end_whatever_fails_on_the_way(transitions, failed) -> None:
    one = managed(Node(("deactivate", "cleanup")), *transitions)
    one.change("shutdown")
    assert (one.state, one.faults.total()) == (Lifecycle.FINALIZED, failed)
