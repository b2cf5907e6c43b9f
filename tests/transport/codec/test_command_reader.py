"""Commands read in rows are those that the decoder reads one by one, and one wrong bit leaves all of them."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from validation.bus_bytes import delivery_of
from vegrip.clock import NS
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.canbus.bus_events import Transmission
from vegrip.transport.canbus.frame_time import BusFrame
from vegrip.transport.canbus.hub_wire import DELIVERY_AT, PLAIN_PLACES, RATE_SWITCH, plain_flags
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.command_reader import SIGNALS, CommandReader, Deliveries, RowHead

FINGERS = ("thumb", "index", "little")
NOW = 7 * NS
NUMBER, BUSY = 2**32 - 2, 5000  # of the first delivery: the number rolls over


def commands() -> list[ForceCommand]:
    life = [NS // 10, NS // 4, NS // 2]
    return [
        ForceCommand(NOW + i, finger, 41 + i, 1.5 + i, 0.125, Reason.RAISE, NOW + i + life[i])
        for i, finger in enumerate(FINGERS)
    ]


def rows_of(given: list[ForceCommand], numbers: list[int] | None = None) -> np.ndarray:
    sender, packets = CanCodec(FINGERS, fd=True), []
    for i, command in enumerate(given):
        (frame,) = sender.encode(command)
        bus_frame = BusFrame(frame.arbitration_id, frame.data, fd=True, has_bit_rate_switch=i % 2 == 0)
        sent = Transmission(NOW, NOW + 1000 * (i + 1), 2, bus_frame)
        number = NUMBER + i if numbers is None else numbers[i]
        packets.append(delivery_of(number, sent, BUSY * (i + 1)))
    return np.array([list(packet) for packet in packets], np.uint8)


def reader_of(**settings: bool) -> tuple[CommandReader, np.ndarray]:
    reader = CanCodec(FINGERS, fd=True, **settings).command_reader()
    assert reader is not None
    return reader, np.array(RowHead(*PLAIN_PLACES, *plain_flags(reader.length), DELIVERY_AT["data"]))


def read(rows: np.ndarray) -> Deliveries | None:
    reader, head = reader_of()
    return reader.read_rows(rows, head)


def resealed(row: np.ndarray) -> None:
    """Give the frame in a row the checksum of what it says now."""
    (identifier,) = struct.unpack_from("<I", row.tobytes(), DELIVERY_AT["identifier"])
    crc = 0xFFFF
    for byte in (*row[DELIVERY_AT["data"] + 2 :].tolist(), identifier & 255, identifier >> 8):
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    row[DELIVERY_AT["data"] : DELIVERY_AT["data"] + 2] = crc & 255, crc >> 8


@pytest.mark.parametrize("sender_time", [False, True])
def test_commands_in_rows_are_those_of_the_decoder(sender_time: bool) -> None:
    reader, head = reader_of(use_sender_time=sender_time)
    rows, decoder = rows_of(commands()), CanCodec(FINGERS, fd=True, use_sender_time=sender_time)
    got = reader.read_rows(rows, head)
    assert got is not None
    assert (got.first, got.rows, got.end, got.busy) == (NUMBER, 3, NOW + 3000, 3 * BUSY)
    for i, (command, sent) in enumerate(zip(got.commands, commands(), strict=True)):
        (identifier,) = struct.unpack_from("<I", rows[i].tobytes(), DELIVERY_AT["identifier"])
        data = rows[i, DELIVERY_AT["data"] :].tobytes()
        one = decoder.decode(Frame(identifier, data, True, NOW + 1000 * (i + 1)))
        assert isinstance(one, ForceCommand)
        assert command == (one.finger, one.normal_force, one.reason, one.stamp, one.expires)
        assert (command.finger, command.normal_force) == (sent.finger, sent.normal_force)
        assert command.expires - command.stamp == sent.expires - sent.stamp


def test_any_wrong_bit_of_flags_identifier_length_or_frame_leaves_all_rows() -> None:
    good = rows_of(commands())
    resealed_rows = good.copy()
    for row in resealed_rows:
        resealed(row)
    assert np.array_equal(resealed_rows, good), "the checksum is that of E2E profile 5"
    number = range(8 * DELIVERY_AT["number"], 8 * (DELIVERY_AT["number"] + 4))
    after_times = range(8 * DELIVERY_AT["identifier"], 8 * good.shape[1])
    ignored = 8 * DELIVERY_AT["flags"] + RATE_SWITCH.bit_length() - 1
    for row in range(3):
        for bit in (*(number if row else ()), *after_times):
            changed = good.copy()
            changed[row, bit // 8] ^= 1 << bit % 8
            assert (read(changed) is None) == (bit != ignored), (row, bit)


@pytest.mark.parametrize("numbers", [[4, 6, 7], [4, 5, 7], [4, 4, 5], [4, 3, 2]])
def test_a_number_that_does_not_follow_leaves_all_rows(numbers: list[int]) -> None:
    assert read(rows_of(commands(), [4, 5, 6])) is not None
    assert read(rows_of(commands(), numbers)) is None


@pytest.mark.parametrize("signal", ["version", "normal_force", "adjustment", "reason"])
def test_a_value_that_means_nothing_leaves_all_rows_though_the_checksum_is_right(signal: str) -> None:
    reader, _ = reader_of()
    rows = rows_of(commands())
    at = DELIVERY_AT["data"] + dict(zip(SIGNALS, reader._places.tolist(), strict=True))[signal]
    nothing = {
        "version": [rows[1, at] ^ 1],
        "normal_force": struct.pack("<f", float("inf")),
        "adjustment": struct.pack("<f", float("nan")),
        "reason": [255],
    }[signal]
    rows[1, at : at + len(nothing)] = list(nothing)
    resealed(rows[1])
    assert read(rows) is None


@pytest.mark.parametrize("raw", [0, 1, 65535])
def test_the_shortest_and_the_longest_lifetime_are_taken(raw: int) -> None:
    rows = rows_of(commands())
    rows[2, -2:] = list(struct.pack("<H", raw))  # [0.1 ms], the last of the frame
    resealed(rows[2])
    got = read(rows)
    assert got is not None
    assert got.commands[2].expires - got.commands[2].stamp == raw * 100_000


def test_a_counter_that_was_taken_before_is_refused_and_the_others_are_read() -> None:
    reader, head = reader_of()
    assert reader.read_rows(rows_of(commands()[:1]), head) is not None
    again = reader.read_rows(rows_of([commands()[0], replace(commands()[1], seq=42)]), head)
    assert again is not None
    assert [one.finger for one in again.commands] == ["index"]
