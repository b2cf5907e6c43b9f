"""States that arrive broken are told by finger, on CAN and on ZeroMQ; what is only old is not among them."""

from collections.abc import Callable, Mapping

import msgpack
import pytest

from vegrip.messages import FingertipState, ForceCommand, Message, Reason
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
from vegrip.transport.codec.protection import P04, P04_HEADER
from vegrip.transport.codec.schema import ROUTES, Topics

FINGERS = ("thumb", "index")
INDEX = FingertipState(5, "index", 1, normal_force=1.0, displacement=1e-4)
COMMAND = ForceCommand(5, "index", 1, 2.0, 0.5, Reason.RAISE, 100)

BYTES: dict[str, Callable[[bytes], bytes]] = {
    "flipped": lambda data: bytes([*data[:-1], data[-1] ^ 1]),
    "cut": lambda data: data[: len(data) // 2],
    "emptied": lambda data: data[:0],
    "padded": lambda data: data + bytes(4),
}


def over_can(message: Message, damage: Callable[[bytes], bytes], *, fd: bool) -> Mapping[str, int]:
    receiver = CanCodec(FINGERS, fd=fd)
    for frame in CanCodec(FINGERS, fd=fd).encode(message):
        receiver.decode(frame._replace(data=damage(frame.data)))
    return receiver.broken


def over_zmq(message: Message, damage: Callable[[bytes], bytes]) -> Mapping[str, int]:
    receiver = MsgpackCodec("", FINGERS)
    encoded = MsgpackCodec("", FINGERS).encode(message)
    assert encoded is not None
    receiver.decode(encoded[0], damage(encoded[1]), 0)
    return receiver.broken


@pytest.mark.parametrize("damage", BYTES)
def test_a_broken_state_is_told_by_its_finger_and_counted(damage: str) -> None:
    """Once for each of its frames, of which a classic one has several."""
    frames = len(CanCodec(FINGERS, fd=False).encode(INDEX))
    assert frames > 1
    assert over_can(INDEX, BYTES[damage], fd=False) == {"index": frames}
    assert over_can(INDEX, BYTES[damage], fd=True) == over_zmq(INDEX, BYTES[damage]) == {"index": 1}


@pytest.mark.parametrize("damage", BYTES)
def test_other_messages_are_not_states(damage: str) -> None:
    assert not over_can(COMMAND, BYTES[damage], fd=True)
    assert not over_zmq(COMMAND, BYTES[damage])


def protected(body: object, topic: str) -> bytes:
    route = Topics("", FINGERS).incoming(topic)
    assert route is not None
    data = bytearray(P04_HEADER) + msgpack.packb(body)
    P04.protect(data, route.data_id)
    return bytes(data)


@pytest.mark.parametrize("body", [{"version": 99}, [1], {}, {"version": 1, "seq": "x"}])
def test_a_state_with_a_good_checksum_that_is_not_understood_is_broken(body: object) -> None:
    receiver = MsgpackCodec("", FINGERS)
    assert receiver.decode("/hand/thumb/state", protected(body, "/hand/thumb/state"), 0) is None
    assert receiver.broken == {"thumb": 1}


def test_a_repeated_state_is_old_and_not_broken() -> None:
    can, network = CanCodec(FINGERS, fd=True), MsgpackCodec("", FINGERS)
    (frame,) = CanCodec(FINGERS, fd=True).encode(INDEX)
    encoded = MsgpackCodec("", FINGERS).encode(INDEX)
    assert encoded is not None
    for _ in range(3):
        can.decode(frame)
        network.decode(*encoded, 0)
    assert can.rejected == network.rejected == {"counter": 2}
    assert not can.broken
    assert not network.broken


def test_what_belongs_to_no_finger_is_not_broken() -> None:
    can, network = CanCodec(FINGERS, fd=True), MsgpackCodec("", FINGERS)
    can.decode(Frame(0x7FF, b"", True, 0))
    can.decode(Frame(0x207, b"", True, 0))  # a finger that is not configured
    network.decode("/hand/nobody/state", b"", 0)
    network.decode("/nothing", b"", 0)
    assert not can.broken
    assert not network.broken


def test_made_up_fingers_with_broken_states_do_not_eat_the_memory() -> None:
    network = MsgpackCodec()
    for i in range(ROUTES + 100):
        network.decode(f"/hand/f{i}/state", b"", 0)
    assert len(network.broken) == ROUTES
    network.decode("/hand/f0/state", b"", 0)
    assert network.broken["f0"] == 2
