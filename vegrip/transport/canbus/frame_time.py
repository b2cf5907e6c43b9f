"""Frames of a CAN bus, its bit rates, and for how long a frame occupies it: exactly, at most, typically."""

from dataclasses import dataclass
from functools import lru_cache
from random import Random
from typing import NamedTuple

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.transport.canbus import bus_records as wire
from vegrip.transport.canbus import frame_bits as text

FD_SIZES = wire.DATA_SIZES  # bytes of data by length code


def fd_size(length: int) -> int:
    """Return how many bytes a CAN FD frame has that holds ``length`` of them; 64 where none does."""
    return next((size for size in FD_SIZES if size >= length), FD_SIZES[-1])


class BusFrame(NamedTuple):
    """A frame as the bus sees it."""

    identifier: int
    data: bytes = b""
    extended: bool = False
    is_remote: bool = False
    fd: bool = False
    has_bit_rate_switch: bool = False
    is_error_passive: bool = False  # FD: the sender is error passive
    length_code: int = -1  # of a remote frame, whose data is absent; -1: from the data

    @property
    def code(self) -> int:
        """The data length code."""
        if self.length_code >= 0:
            return self.length_code
        return FD_SIZES.index(len(self.data))


@dataclass(frozen=True, slots=True)
class BitTiming:
    """Bit rates of a bus."""

    bitrate: int = parameter(1_000_000, unit="bit/s", low=1_000, high=20_000_000)
    data_bitrate: int = parameter(
        5_000_000, unit="bit/s", low=1_000, high=20_000_000, doc="of FD frames with bit-rate switch"
    )


class _Kind(NamedTuple):
    """The flags of a frame, in the order of the fields of :class:`BusFrame`."""

    extended: bool
    is_remote: bool
    fd: bool
    has_bit_rate_switch: bool
    is_error_passive: bool


FRAME_KINDS = [_Kind(*(bool(flags >> bit & 1) for bit in range(5))) for flags in range(wire.FRAME_FLAGS + 1)]
KIND_FLAGS: dict[tuple[bool, ...], int] = {kind: flags for flags, kind in enumerate(FRAME_KINDS)}


def has_form(identifier: int, flags: int, code: int, length: int) -> bool:
    """Return whether a frame can have these numbers, ``length`` being that of its data [bytes]."""
    if code > (15 if flags & wire.FD else 8) or identifier >> (29 if flags & wire.EXTENDED else 11):
        return False
    return length == (0 if flags & wire.REMOTE else FD_SIZES[code])


def write_record(frame: BusFrame, record: wire.Frame) -> None:
    record.identifier, record.flags, record.code = frame.identifier, KIND_FLAGS[frame[2:7]], frame.code
    record.data[: len(frame.data)] = frame.data


def frame_duration(frame: BusFrame, timing: BitTiming) -> int:
    """Return how long ``frame`` and the gap after it keep the bus busy [ns]."""
    return text.frame_duration(_record(frame), timing.bitrate, timing.data_bitrate)


def frame_bits(frame: BusFrame) -> tuple[int, int]:
    return text.frame_bits(_record(frame))


def _record(frame: BusFrame) -> wire.Frame:
    record = wire.Frame()
    write_record(frame, record)
    return record


@lru_cache(maxsize=1024)
def longest_duration(identifier: int, length: int, fd: bool, timing: BitTiming) -> int:
    """Return the duration [ns] that no standard data frame with this identifier and length exceeds.

    Classic: 55 bits and 10 for each byte [DavisBurnsBrilLukkien2007]_. FD with bit-rate switch: the bits up
    to BRS are known from the identifier; after them a stuff bit follows at most every fourth bit.
    """
    if not fd:
        return round(NS * (55 + 10 * length) / timing.bitrate)
    header, run = text.header_bits(_record(BusFrame(identifier, fd=True, has_bit_rate_switch=True)))
    after = 5 + 8 * length  # ESI, length code, data
    free = wire.LONGEST_RUN - 1 - run % wire.RUNS  # bits that may follow before the first stuff bit
    stuff = 0 if after < free else 1 + (after - free) // (wire.LONGEST_RUN - 1)
    crc = 4 + (17 if length <= 16 else 21)
    fast = after + stuff + crc + 1 + crc // 4 + 1
    return round(NS * ((header + text.AFTER_CRC_FD) / timing.bitrate + fast / timing.data_bitrate))


@lru_cache(maxsize=256)
def typical_duration(length: int, fd: bool, timing: BitTiming) -> int:
    """Return the duration [ns] of a standard frame with ``length`` bytes of random data.

    For estimates of the load where the exact count would cost more than it is worth. A length that no frame
    has, as other programs on a bus in software may send, counts as the next one that CAN FD has.
    """
    length = fd_size(length)
    generator = Random(length)  # noqa: S311 (no secret)
    frames = [
        BusFrame(generator.getrandbits(11), generator.randbytes(length), fd=fd, has_bit_rate_switch=fd)
        for _ in range(64)
    ]
    return round(sum(frame_duration(frame, timing) for frame in frames) / len(frames))
