"""What a node sends arrives over the kernel as it was, classic and FD, and when it arrived is known."""

import time
from dataclasses import replace
from pathlib import Path

import can
import cantools
import pytest
import vegrip.proto

from vegrip.messages import Estimate, FingertipState, ForceCommand, Reason, SlipMargin
from vegrip.transport.codec import CanCodec

SECOND = 1_000_000_000
MESSAGES = (
    FingertipState(SECOND, "index", 7, 4.0, 0.5, -0.25, 0.002, 0.001, 31.5, 0.0, 0.001, 0.004),
    FingertipState(SECOND, "thumb", 8, normal_force=2.5),
    ForceCommand(SECOND, "index", 7, 4.2, 0.2, Reason.RAISE, SECOND + 50_000_000),
    SlipMargin(SECOND, "thumb", 7, Estimate(0.4, 0.03, True, 0.002), 0.33, 0.95, 1.2, 4.0, 2.5),
)


def received(endpoint, patience=60.0):
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        if found := endpoint.receive(0.1):
            return found[0]
    raise AssertionError("nothing came")


def carried(sender, receiver, message):
    """Send until the message is there: its parts must come within 5 ms, too soon for a busy machine."""
    for seq in range(50):
        sender.send(replace(message, seq=seq))
        if found := receiver.receive(0.2):
            return found[0]
    raise AssertionError("nothing came")


def content(message):
    """Without what no receiver can know - the sender's stamp, the end of a lifetime - and the number."""
    left_out = ("stamp", "expires", "seq")
    return {name: str(getattr(message, name)) for name in message.__slots__ if name not in left_out}


@pytest.mark.parametrize("fd", [True, False])
@pytest.mark.parametrize("message", MESSAGES, ids=lambda m: type(m).__name__)
def test_a_message_arrives_as_the_codec_alone_would_give_it(endpoint, message, fd):
    sender, receiver = endpoint(fd=fd), endpoint(fd=fd)
    codec = CanCodec(("thumb", "index"), fd=fd)
    expected = next(m for frame in codec.encode(message) if (m := codec.decode(frame)) is not None)
    assert content(carried(sender, receiver, message)) == content(expected)
    assert set(receiver.rejected) <= {"incomplete", "lost", "counter"}  # what parts that came too late leave


@pytest.mark.parametrize("fd", [True, False])
def test_other_tools_read_the_frames_with_the_database(endpoint, bus, fd):
    listener = bus()
    endpoint(fd=fd).send(MESSAGES[0])
    frame = listener.recv(60.0)
    assert (frame.is_fd, frame.bitrate_switch, len(frame.data)) == (
        (True, True, 48) if fd else (False, False, 8)
    )
    file = Path(vegrip.proto.__file__).parent / "fingertip.dbc"
    database = cantools.database.load_file(file, frame_id_mask=0x7C0)
    decoded = database.get_message_by_frame_id(frame.arbitration_id).decode(frame.data)
    assert decoded["normal_force"] == pytest.approx(4.0)
    assert decoded["tangential_force_y"] == pytest.approx(-0.25)


def test_the_stamp_is_when_the_frame_arrived_not_when_it_was_read(endpoint):
    sender, receiver = endpoint(), endpoint()
    before = time.monotonic_ns()
    sender.send(MESSAGES[1])
    after = time.monotonic_ns()
    time.sleep(0.2)
    received(receiver)
    slack = 2_000_000  # [ns] the wall clock, in which the kernel stamps, is compared with the monotonic one
    assert before - slack <= receiver.arrivals[0] <= after + slack
    assert time.monotonic_ns() - receiver.arrivals[0] > 0.19 * SECOND


def test_frames_without_meaning_are_passed_over(endpoint, bus):
    receiver, other = endpoint(), bus()
    other.send(can.Message(arbitration_id=0x12345, data=b"extended"))
    other.send(can.Message(arbitration_id=0x101, is_remote_frame=True, is_extended_id=False))
    other.send(can.Message(arbitration_id=0x7FF, data=b"unknown", is_extended_id=False))
    endpoint().send(MESSAGES[1])
    assert received(receiver).normal_force == 2.5
    assert receiver.rejected == {"unknown_id": 1}


def test_filters_of_the_kernel_keep_other_hands_from_waking_a_node(endpoint):
    mine = {"can_id": 1 << 3, "can_mask": 0x38}  # the bits of the hand's number
    choosy, all_ears = endpoint(1, options={"can_filters": [mine]}), endpoint(1)
    other, own = endpoint(0), endpoint(1)
    for seq in range(5):
        other.send(FingertipState(0, "thumb", seq, normal_force=1.0))
    own.send(FingertipState(0, "thumb", 0, normal_force=2.0))
    assert received(choosy).normal_force == received(all_ears).normal_force == 2.0
    assert (choosy._codec.foreign, all_ears._codec.foreign) == (0, 5)
