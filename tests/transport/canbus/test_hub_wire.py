"""The packets of the bus byte by byte, and the numbers of Linux that they carry (linux/can/error.h)."""

import struct

import pytest

from vegrip.transport.canbus import bus_records as wire
from vegrip.transport.canbus.bus_events import ErrorState
from vegrip.transport.canbus.frame_time import FRAME_KINDS, has_form
from vegrip.transport.canbus.hub_wire import (
    DELIVERY_AT,
    REQUEST_AT,
    pack_filters,
    pack_request,
    pairs_of,
    reported_state,
    split_deliveries,
    unpack_delivery,
    unpack_filters,
)

LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
EXTENDED, REMOTE, FD, SWITCH, ERROR = 1, 2, 4, 8, 32  # flags as they travel
MOST = 512  # filters


def delivered(number: int, flags: int, code: int, data: bytes) -> bytes:
    return struct.pack("<IQQHIBB", number, 10**15, 777, 3, 0x123, flags, code) + data


def test_a_request_has_time_identifier_flags_length_code_and_data_one_behind_the_other() -> None:
    for code, length in enumerate(LENGTHS):
        data = bytes(range(length))
        packet = pack_request(10**15, 0x1ABCDE, data, FD | SWITCH)
        assert packet == struct.pack("<QIBB", 10**15, 0x1ABCDE, 12, code) + data
    assert pack_request(1, 2, b"", REMOTE, 5) == struct.pack("<QIBB", 1, 2, 2, 5)
    assert REQUEST_AT == {"time": 0, "identifier": 8, "flags": 12, "code": 13, "data": 14}
    assert wire.REQUEST_BYTES == 14


def test_a_delivery_is_numbered_and_stamped_and_says_who_sent_it() -> None:
    found = unpack_delivery(delivered(7, FD, 9, bytes(12)))
    assert found is not None
    assert found[:7] == (7, 10**15, 777, 3, 0x123, FD, 9)
    assert (found.frame.data, found.frame.fd, found.frame.extended, found.is_error) == (
        bytes(12),
        True,
        False,
        False,
    )
    assert DELIVERY_AT == {
        "number": 0, "end": 4, "busy": 12, "identifier": 22, "flags": 26, "code": 27, "data": 28,
    }  # fmt: skip
    assert wire.DELIVERY_BYTES == 28
    error = unpack_delivery(delivered(7, ERROR, 8, bytes(8)))
    assert error is not None
    assert error.is_error
    assert unpack_delivery(delivered(7, FD, 9, b"")[:27]) is None
    assert unpack_delivery(delivered(7, 0, 0, b"")) is not None


def test_deliveries_are_split_by_their_lengths_and_a_rest_is_left_as_it_is() -> None:
    some = [delivered(i, FD, code, bytes([i] * LENGTHS[code])) for i, code in enumerate((0, 8, 15, 9))]
    some.append(delivered(9, REMOTE, 8, b""))
    some.append(delivered(10, FD, 1, b"x"))
    assert split_deliveries(b"".join(some)) == some
    assert split_deliveries(b"".join(some) + b"rest") == [*some, b"rest"]
    assert split_deliveries(b"") == [b""]
    assert split_deliveries(delivered(1, FD, 16, b"")) == [delivered(1, FD, 16, b"")]


@pytest.mark.parametrize(
    ("identifier", "flags", "code", "length", "can_be"),
    [
        (0x7FF, 0, 8, 8, True),
        (0x800, 0, 8, 8, False),
        (0x1FFFFFFF, EXTENDED, 8, 8, True),
        (0x20000000, EXTENDED, 8, 8, False),
        (1, 0, 9, 12, False),
        (1, FD, 15, 64, True),
        (1, FD, 16, 64, False),
        (1, FD, 9, 11, False),
        (1, REMOTE, 8, 0, True),
        (1, REMOTE, 8, 8, False),
    ],
)
def test_a_frame_has_the_bits_and_bytes_of_its_kind(
    identifier: int, flags: int, code: int, length: int, can_be: bool
) -> None:
    assert has_form(identifier, flags, code, length) == can_be
    assert FRAME_KINDS[flags] == tuple(bool(flags & bit) for bit in (1, 2, 4, 8, 16))
    assert len(FRAME_KINDS) == 32


def test_filters_travel_as_pairs_behind_their_number() -> None:
    pairs = [(0x123, 0x7FF), (0x80000456, 0x9FFFFFFF)]
    packet = struct.pack("<QIBBIIII", 0, 2, 64, 0, *pairs[0], *pairs[1])
    assert pack_filters(pairs) == packet
    assert unpack_filters(packet) == pairs
    assert pack_filters([]) == struct.pack("<QIBBII", 0, 1, 64, 0, 0, 0), "without any, everything passes"
    most = pack_filters(pairs[:1] * MOST)
    assert unpack_filters(most) == pairs[:1] * MOST
    assert len(most) <= wire.PACKET_BYTES == 16 + 8 * MOST
    for broken in (
        packet[:13], packet[:-1], packet + b"\0", pack_filters(pairs[:1] * (MOST + 1)),
        struct.pack("<QIBB", 0, 0, 64, 0), struct.pack("<QIBBII", 0, 1, 65, 0, 1, 1),
    ):  # fmt: skip
        assert unpack_filters(broken) is None


def test_filters_of_python_can_have_32_bits_and_may_ask_for_one_kind_of_identifier() -> None:
    given = [
        {"can_id": 0x123, "can_mask": 0x7FF},
        {"can_id": 0x80000123, "can_mask": 2**32 - 1, "extended": True},
        {"can_id": 0x123, "can_mask": 0x7FF, "extended": False},
    ]
    assert pairs_of(given) == [(0x123, 0x7FF), (0x80000123, 2**32 - 1), (0x123, 0x800007FF)]
    assert len(pairs_of(given[:1] * MOST)) == MOST
    with pytest.raises(ValueError, match="513 filters"):
        pairs_of(given[:1] * (MOST + 1))
    for identifier, mask in ((-1, 0), (2**32, 0), (0, -1), (0, 2**32)):
        with pytest.raises(ValueError, match="32 bits"):
            pairs_of([{"can_id": identifier, "can_mask": mask}])


@pytest.mark.parametrize(
    ("classes", "controller", "state"),
    [
        (0x40, 0, ErrorState.OFF),
        (0x100, 0, ErrorState.ACTIVE),
        (0x140, 0, ErrorState.OFF),
        (0x04, 0x10, ErrorState.PASSIVE),
        (0x04, 0x20, ErrorState.PASSIVE),
        (0x04, 0x40, ErrorState.ACTIVE),
        (0x04, 0x08, None),
        (0x88, 0x10, None),
    ],
)
def test_an_error_frame_tells_the_state_of_the_controller(
    classes: int, controller: int, state: ErrorState | None
) -> None:
    assert reported_state(classes, bytes([0, controller, 0, 0, 0, 0, 0, 0])) is state
    if classes == 0x04:
        assert reported_state(classes, b"\0") is None


def test_error_frames_have_the_numbers_of_linux() -> None:
    assert (wire.CONTROLLER, wire.PROTOCOL, wire.ACKNOWLEDGEMENT) == (0x04, 0x08, 0x20)
    assert (wire.BUS_OFF, wire.BUS_ERROR, wire.RESTARTED, wire.HAS_COUNTERS) == (0x40, 0x80, 0x100, 0x200)
    assert (wire.RECEIVE_PASSIVE, wire.TRANSMIT_PASSIVE, wire.ERROR_ACTIVE) == (0x10, 0x20, 0x40)
    assert (wire.OF_BIT, wire.OF_STUFFING, wire.SENDING, wire.ACK_SLOT, wire.IN_DATA) == (
        1,
        4,
        0x80,
        0x19,
        0x0A,
    )
    assert (wire.EXTENDED, wire.REMOTE, wire.FD, wire.SWITCH, wire.ERROR_STATE, wire.ERROR) == (
        1,
        2,
        4,
        8,
        16,
        32,
    )
    assert wire.DATA_SIZES == LENGTHS
    assert len({wire.NO_ERROR, wire.BIT_ERROR, wire.STUFF_ERROR, wire.ACK_ERROR}) == 4
    assert len({wire.SENT, wire.FAILED, wire.CHANGED}) == len({wire.ACTIVE, wire.PASSIVE, wire.OFF}) == 3
