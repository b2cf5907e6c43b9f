"""The checksums are those of AUTOSAR, and no damaged or misplaced message is taken."""

import dataclasses
from collections.abc import Callable

import pytest

from vegrip.messages import Message
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
from vegrip.transport.codec.protection import P04, P04_HEADER

FINGERS = ("thumb", "index")


def reflect(value: int, width: int) -> int:
    return int(f"{value:0{width}b}"[::-1], 2)


def crc(data: bytes, width: int, polynomial: int, start: int, final: int, reflected: bool = False) -> int:
    """Compute a CRC bit by bit, straight from its definition."""
    register, top = start, 1 << (width - 1)
    for byte in data:
        register ^= (reflect(byte, 8) if reflected else byte) << (width - 8)
        for _ in range(8):
            register = ((register << 1) ^ (polynomial if register & top else 0)) & ((1 << width) - 1)
    return (reflect(register, width) if reflected else register) ^ final


def crc8_of_profile_11(data: bytes, data_id: int) -> int:
    return crc(data_id.to_bytes(2, "little") + data[1:], 8, 0x1D, 0x00, 0x00)


def crc16_of_profile_5(data: bytes, data_id: int) -> int:
    return crc(data[2:] + data_id.to_bytes(2, "little"), 16, 0x1021, 0xFFFF, 0x0000)


def crc32_of_profile_4(data: bytes) -> int:
    return crc(data[:8] + data[12:], 32, 0xF4ACFB13, 0xFFFFFFFF, 0xFFFFFFFF, reflected=True)


def test_the_bitwise_crc_gives_the_published_check_values() -> None:
    """AUTOSAR, Specification of CRC Routines: results for "123456789"."""
    digits = b"123456789"
    assert crc(digits, 8, 0x1D, 0xFF, 0xFF) == 0x4B
    assert crc(digits, 16, 0x1021, 0xFFFF, 0x0000) == 0x29B1
    assert crc(digits, 32, 0xF4ACFB13, 0xFFFFFFFF, 0xFFFFFFFF, reflected=True) == 0x1697D06A


def test_classic_frames_carry_the_crc_of_profile_11(examples: list[Message]) -> None:
    for frame in frames(examples, fd=False):
        assert frame.data[0] == crc8_of_profile_11(frame.data, frame.arbitration_id)


def test_fd_frames_carry_the_crc_of_profile_5(examples: list[Message]) -> None:
    for frame in frames(examples, fd=True):
        stored = int.from_bytes(frame.data[:2], "little")
        assert stored == crc16_of_profile_5(frame.data, frame.arbitration_id)


def test_payloads_carry_length_and_crc_of_profile_4(examples: list[Message]) -> None:
    for message in examples:
        _, payload = MsgpackCodec().encode(message) or ("", b"")
        assert int.from_bytes(payload[:2], "big") == len(payload)
        assert int.from_bytes(payload[2:4], "big") == message.seq
        assert int.from_bytes(payload[8:12], "big") == crc32_of_profile_4(payload)


def test_a_header_alone_is_checked_and_what_is_shorter_is_none() -> None:
    """An empty payload is one that profile 4 protects, too."""
    header = bytearray(P04_HEADER)
    P04.protect(header, 0x00A0_0B0C)
    assert int.from_bytes(header[8:12], "big") == crc32_of_profile_4(bytes(header))
    assert P04.check(bytes(header), 0x00A0_0B0C)
    assert not P04.check(bytes(header), 0x00A0_0B0D)
    for length in range(P04_HEADER):
        assert not P04.check(bytes(header[:length]), 0x00A0_0B0C)


def test_the_counter_on_the_wire_is_the_sequence_number(examples: list[Message]) -> None:
    for seq in (0, 14, 15, 255, 256, 2**32 - 1, 2**32):
        state = dataclasses.replace(examples[0], seq=seq)
        classic, fd = (CanCodec(FINGERS, fd=fd).encode(state)[0].data for fd in (False, True))
        assert classic[1] & 0x0F == seq % 15
        assert fd[2] == seq % 256
        assert int.from_bytes(fd[2:6], "little") == seq % 2**32


def frames(messages: list[Message], fd: bool) -> list[Frame]:
    sender = CanCodec(FINGERS, fd=fd)
    return [frame for message in messages for frame in sender.encode(message)]


def flipped(data: bytes) -> list[bytes]:
    bits = int.from_bytes(data, "little")
    return [(bits ^ 1 << i).to_bytes(len(data), "little") for i in range(8 * len(data))]


@pytest.mark.parametrize("fd", [False, True])
def test_every_single_bit_flip_is_refused(fd: bool, examples: list[Message]) -> None:
    receiver = CanCodec(FINGERS, fd=fd)
    damaged = [frame._replace(data=data) for frame in frames(examples, fd) for data in flipped(frame.data)]
    assert [receiver.decode(frame) for frame in damaged] == [None] * len(damaged)
    assert receiver.rejected == {"checksum": len(damaged)}


def test_every_single_bit_flip_of_a_payload_is_refused(examples: list[Message]) -> None:
    receiver = MsgpackCodec()
    for message in examples:
        topic, payload = MsgpackCodec().encode(message) or ("", b"")
        assert all(receiver.decode(topic, data, 0) is None for data in flipped(payload))
    assert set(receiver.rejected) == {"checksum"}


@pytest.mark.parametrize("fd", [False, True])
def test_a_burst_as_wide_as_the_checksum_is_refused(fd: bool, examples: list[Message]) -> None:
    receiver = CanCodec(FINGERS, fd=fd)
    for frame in frames(examples, fd):
        for start in range(len(frame.data) - 1):
            data = bytearray(frame.data)
            data[start] ^= 0xFF
            assert receiver.decode(frame._replace(data=bytes(data))) is None
    assert set(receiver.rejected) == {"checksum"}


def same_length(a: Frame, b: Frame) -> bool:
    return len(a.data) == len(b.data) and a.arbitration_id != b.arbitration_id


@pytest.mark.parametrize("fd", [False, True])
def test_a_good_frame_under_the_identifier_of_another_is_refused(fd: bool, examples: list[Message]) -> None:
    every = frames(examples, fd)
    receiver = CanCodec(FINGERS, fd=fd)
    misplaced = [
        a._replace(arbitration_id=b.arbitration_id) for a in every for b in every if same_length(a, b)
    ]
    misplaced += [a._replace(arbitration_id=a.arbitration_id ^ 1) for a in every]
    assert all(receiver.decode(frame) is None for frame in misplaced)
    assert receiver.rejected == {"checksum": len(misplaced)} or set(receiver.rejected) <= {
        "checksum",
        "finger",
    }


Move = Callable[[str], str]


@pytest.mark.parametrize(
    "move",
    [lambda t: t.replace("index", "thumb"), lambda t: f"/right{t.removeprefix('/left')}"],
    ids=["another finger", "another hand"],
)
def test_a_good_payload_on_another_topic_is_refused(move: Move, examples: list[Message]) -> None:
    topic, payload = MsgpackCodec("left").encode(examples[3]) or ("", b"")
    receiver = MsgpackCodec(move(topic).split("/")[1])
    assert receiver.decode(move(topic), payload, 0) is None
    assert receiver.rejected == {"checksum": 1}
