"""Each message is passed on once, wherever its topic is seen."""

import itertools
import time
from collections import Counter
from types import SimpleNamespace

import pytest

from vegrip.bridges.node_topics import NodeTopics
from vegrip.messages import FingertipState, Lifecycle, NodeStatus, SlipMargin
from vegrip.runtime.control_socket import ControlServer
from vegrip.runtime.registry import Entry, registered
from vegrip.runtime.telemetry import Direction
from vegrip.runtime.telemetry_socket import TelemetrySocket
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

PATIENCE = 20.0  # [s] on a busy machine
STATE, MARGIN = "/hand/thumb/state", "/hand/thumb/slip_margin"


@pytest.fixture
def running(runtime):
    """Two nodes: a hand that sends states, and a controller that hears them and sends margins."""
    with registered(Entry("/hand", "echo")) as _, registered(Entry("/grip", "echo")) as _:
        nodes = [Running("/hand"), Running("/grip")]
        yield nodes
        for node in nodes:
            node.close()


class Running:
    def __init__(self, name: str) -> None:
        entry = Entry(name, "echo")
        self.telemetry = TelemetrySocket(entry.telemetry, MsgpackCodec(), ("thumb",))
        calls = {"topics": self.telemetry.topics}
        self.control = ControlServer(entry.control, SimpleNamespace(calls=calls), Counter())

    def say(self, message, direction: Direction) -> None:
        self.telemetry.count(message, direction)
        self.telemetry.publish([(message, direction)])

    def close(self) -> None:
        self.control.close()
        self.telemetry.close()


def state(number: int) -> FingertipState:
    return FingertipState(number, "thumb", number, normal_force=1.0)


def test_a_message_that_is_seen_at_sender_and_receiver_comes_once(running) -> None:
    hand, grip = running
    numbers = itertools.count()

    def send():
        one = state(next(numbers))
        hand.say(one, Direction.OUT)
        grip.say(one, Direction.IN)
        grip.say(SlipMargin(one.stamp, "thumb", one.seq), Direction.OUT)

    send()
    topics = NodeTopics()
    assert topics.look() == {STATE: FingertipState, MARGIN: SlipMargin}
    heard = []
    ends = time.monotonic() + PATIENCE
    while len(heard) < 50 and time.monotonic() < ends:
        for node in running:
            node.telemetry.listen()
        send()
        heard += topics.read({STATE})
    topics.rest()
    stamps = [message.stamp for _, message in heard]
    assert len(stamps) >= 50
    assert stamps == list(range(stamps[0], stamps[0] + len(stamps)))
    assert {topic for topic, _ in heard} == {STATE}


def test_a_topic_that_nobody_asks_for_costs_its_node_nothing(running) -> None:
    hand, grip = running
    hand.say(state(0), Direction.OUT)
    grip.say(SlipMargin(0, "thumb", 0), Direction.OUT)
    topics = NodeTopics()
    topics.look()
    ends = time.monotonic() + PATIENCE
    while not hand.telemetry.wanted and time.monotonic() < ends:
        topics.read({STATE})
        for node in running:
            node.telemetry.listen()
    assert hand.telemetry.wants(FingertipState, "thumb", Direction.OUT)
    assert not grip.telemetry.wanted
    topics.rest()


def test_the_status_of_every_node_comes(running) -> None:
    topics, heard = NodeTopics(), set()
    ends = time.monotonic() + PATIENCE
    while len(heard) < 2 and time.monotonic() < ends:
        for node, name in zip(running, ("/hand", "/grip"), strict=True):
            node.telemetry.listen()
            node.say(NodeStatus(1, name, 1, Lifecycle.ACTIVE), Direction.OUT)
        topics.look()
        heard |= {message.node for _, message in topics.read({"/diagnostics"})}
    topics.rest()
    assert heard == {"/hand", "/grip"}
