"""Topics, namespaces and remappings."""

import pytest

from vegrip.errors import ConfigError
from vegrip.messages import FingertipState, Message
from vegrip.transport.codec import CanCodec, MsgpackCodec

TOPICS = ["/hand/index/state", "/hand/index/contact", "/hand/index/slip_margin"]
TOPICS += ["/hand/index/force_command", "/hand/index/model_health", "/hand/index/learned", "/diagnostics"]


def topics(codec: MsgpackCodec, examples: list[Message]) -> list[str]:
    return [sent[0] for message in examples if (sent := codec.encode(message))]


@pytest.mark.parametrize(
    ("namespace", "prefix"),
    [("", ""), ("left", "/left"), ("/left", "/left"), ("robot/left/", "/robot/left"), ("/", "")],
)
def test_a_namespace_stands_in_front(namespace: str, prefix: str, examples: list[Message]) -> None:
    assert topics(MsgpackCodec(namespace), examples) == [prefix + topic for topic in TOPICS]


def test_two_hands_on_one_network_do_not_hear_each_other(examples: list[Message]) -> None:
    left, right = MsgpackCodec("left"), MsgpackCodec("right")
    for message in examples:
        assert right.decode(*(left.encode(message) or ("", b"")), stamp=0) is None
    assert right.rejected == {"unknown_topic": len(examples)}


def test_a_remapped_topic_has_its_wire_name_on_both_sides(examples: list[Message]) -> None:
    remap = {"/hand/index/state": "/glove/finger2/state"}
    sender, receiver = MsgpackCodec(remap=remap), MsgpackCodec(remap=remap)
    sent = sender.encode(examples[0])
    assert sent is not None
    assert sent[0] == "/glove/finger2/state"
    assert receiver.decode(*sent, stamp=0) == examples[0]


def test_a_remapping_of_one_side_reaches_a_plain_topic_of_another_hand(examples: list[Message]) -> None:
    sent = MsgpackCodec("sim").encode(examples[0])
    receiver = MsgpackCodec(remap={"/hand/index/state": "/sim/hand/index/state"})
    assert sent is not None
    assert receiver.decode(*sent, stamp=0) == examples[0]


def test_only_configured_fingers_are_heard() -> None:
    receiver = MsgpackCodec(fingers=["thumb"])
    for finger in ("thumb", "index"):
        receiver.decode(*(MsgpackCodec().encode(FingertipState(0, finger, 0)) or ("", b"")), stamp=0)
    assert receiver.rejected == {"unknown_topic": 1}


@pytest.mark.parametrize("name", ["", "in dex", "index/state", "x" * 65, "zeigefinger\n"])
def test_a_name_that_cannot_stand_in_a_topic_is_refused(name: str) -> None:
    with pytest.raises(ConfigError):
        MsgpackCodec(fingers=[name])


def test_a_namespace_that_cannot_stand_in_a_topic_is_refused() -> None:
    with pytest.raises(ConfigError, match="namespace"):
        MsgpackCodec("left hand")


@pytest.mark.parametrize(
    ("fingers", "hand"),
    [(["a", "a"], 0), ([str(n) for n in range(9)], 0), (["thumb"], 8), (["thumb"], -1)],
)
def test_more_than_the_identifier_holds_is_refused(fingers: list[str], hand: int) -> None:
    with pytest.raises(ConfigError):
        CanCodec(fingers, fd=True, hand=hand)


def test_eight_hands_of_eight_fingers_share_a_bus() -> None:
    fingers = [f"finger{number}" for number in range(8)]
    seen: set[int] = set()
    for hand in range(8):
        sender, receiver = (CanCodec(fingers, fd=True, hand=hand) for _ in range(2))
        for finger in fingers:
            (frame,) = sender.encode(FingertipState(0, finger, 0, float(hand)))
            seen.add(frame.arbitration_id)
            state = receiver.decode(frame)
            assert isinstance(state, FingertipState)
            assert (state.finger, state.normal_force) == (finger, hand)
    assert len(seen) == 64


def test_the_namespace_of_a_node_is_the_hand_on_can(examples: list[Message]) -> None:
    from dataclasses import replace

    status = replace(examples[-1], node="left/grasp_force")  # type: ignore[call-arg]
    received = CanCodec(["thumb"], fd=True).decode(CanCodec(["thumb"], fd=True).encode(status)[0])
    assert received.node == "grasp_force"  # type: ignore[union-attr]
