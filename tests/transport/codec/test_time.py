"""Whose clock a message carries, and when a command ends."""

import dataclasses

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from vegrip.messages import FingertipState, ForceCommand, Message, Reason
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec

FINGERS = ("thumb",)
MICROSECOND, MILLISECOND, HOUR = 1_000, 1_000_000, 3_600_000_000_000


def one(frame: Frame, received_at: int, use_sender_time: bool) -> Message | None:
    codec = CanCodec(FINGERS, fd=frame.fd, use_sender_time=use_sender_time)
    return codec.decode(frame._replace(stamp=received_at))


@pytest.mark.parametrize("fd", [False, True])
def test_the_stamp_is_the_receive_time(fd: bool) -> None:
    (frame,) = CanCodec(FINGERS, fd=fd).encode(FingertipState(123, "thumb", 0))
    assert one(frame, 7_000_000_123, False).stamp == 7_000_000_123  # type: ignore[union-attr]


@example(sent=5 * HOUR, delay=-HOUR // 2)
@example(sent=5 * HOUR, delay=HOUR // 2)
@given(sent=st.integers(0, 2000 * HOUR), delay=st.integers(-HOUR // 2, HOUR // 2))
def test_the_sender_time_is_recovered_across_the_wrap_of_its_counter(sent: int, delay: int) -> None:
    sent -= sent % MICROSECOND
    (frame,) = CanCodec(FINGERS, fd=True).encode(FingertipState(sent, "thumb", 0))
    assert one(frame, sent + delay, True).stamp == sent  # type: ignore[union-attr]


@pytest.mark.parametrize("fd", [False, True])
@pytest.mark.parametrize("lifetime", [0, 2 * MILLISECOND, 50 * MILLISECOND, 500 * MILLISECOND])
def test_a_command_lives_as_long_after_reception_as_after_sending(lifetime: int, fd: bool) -> None:
    command = ForceCommand(HOUR, "thumb", 0, 1.0, 0.0, Reason.HOLD, HOUR + lifetime)
    received = one(CanCodec(FINGERS, fd=fd).encode(command)[0], 5 * HOUR, use_sender_time=False)
    assert (received.stamp, received.expires) == (5 * HOUR, 5 * HOUR + lifetime)  # type: ignore[union-attr]


@pytest.mark.parametrize("fd", [False, True])
@pytest.mark.parametrize(
    ("lifetime", "most"), [(51_234_567, 51_234_567), (10 * HOUR, 6_553_500_000), (-HOUR, 0)]
)
def test_a_command_never_lives_longer_than_it_may(lifetime: int, most: int, fd: bool) -> None:
    command = ForceCommand(HOUR, "thumb", 0, 1.0, 0.0, Reason.HOLD, HOUR + lifetime)
    received = one(CanCodec(FINGERS, fd=fd).encode(command)[0], 0, use_sender_time=False)
    assert 0 <= received.expires <= most  # type: ignore[union-attr]


def test_a_payload_keeps_the_stamps_of_the_sender() -> None:
    command = ForceCommand(HOUR, "thumb", 0, 1.0, 0.0, Reason.HOLD, HOUR + 50 * MILLISECOND)
    codec = MsgpackCodec()
    received = codec.decode(*(codec.encode(command) or ("", b"")), stamp=7)
    assert received == command


def test_with_clocks_apart_a_payload_is_stamped_when_received() -> None:
    command = ForceCommand(HOUR, "thumb", 0, 1.0, 0.0, Reason.HOLD, HOUR + 50 * MILLISECOND)
    codec = MsgpackCodec(use_sender_time=False)
    received = codec.decode(*(codec.encode(command) or ("", b"")), stamp=7)
    assert received == dataclasses.replace(command, stamp=7, expires=7 + 50 * MILLISECOND)


@pytest.mark.parametrize("at", [-(2**63), -1, 0, 2**63 - 1])
def test_a_payload_carries_every_time_of_64_bits(at: int) -> None:
    """Also one before the zero of a clock; moved to ours, times keep what lies between them."""
    command = ForceCommand(at, "thumb", 0, 1.0, 0.0, Reason.HOLD, at)
    topic, payload = MsgpackCodec().encode(command) or ("", b"")
    assert MsgpackCodec().decode(topic, payload, stamp=7) == command
    moved = dataclasses.replace(command, stamp=7, expires=7)
    assert MsgpackCodec(use_sender_time=False).decode(topic, payload, stamp=7) == moved
