"""How long a frame occupies a CAN bus, from its very bits.

Classic CAN [ISO2015]_: start of frame to the end of the CRC is stuffed; then follow CRC delimiter,
acknowledgement and its delimiter, 7 bits end of frame, 3 bits between frames. For worst-case contents this is
the bound of [DavisBurnsBrilLukkien2007]_, ``g + 8 n + 13 + floor((g + 8 n - 1) / 4)`` bits.

CAN FD: start of frame to the end of the data is stuffed; the CRC field (stuff count 4, CRC 17 or 21) has
fixed stuff bits instead, one in front and one after every fourth bit. From the bit after BRS to the CRC
delimiter the data bit rate holds [BordoloiSamii2014]_. (Exactly, the rate changes at the sample points of BRS
and of the CRC delimiter; here it changes at their ends.)
"""

from dataclasses import dataclass
from functools import lru_cache
from random import Random
from typing import NamedTuple

from vegrip.clock import NS
from vegrip.transport.canbus.kernels.bit_stuffing import (
    LONGEST_RUN,
    Run,
    crc15_bit_by_bit,
    crc15_bytes,
    stuff_bit_by_bit,
    stuff_bytes,
)
from vegrip.transport.canbus.kernels.frame_fields import AFTER_CRC, AFTER_CRC_FD, DATA_SIZES

FD_SIZES = DATA_SIZES  # bytes of data by length code


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
    def arbitration_key(self) -> int:
        """The arbitration field as a number; the lower one wins the bus.

        11 bits, RTR (or SRR of an extended frame, recessive), IDE, 18 bits, RTR: a standard frame beats the
        extended one of equal first bits, a data frame the remote one.
        """
        if self.extended:
            return (
                (self.identifier >> 18 << 21)
                | (0b11 << 19)
                | ((self.identifier & 0x3FFFF) << 1)
                | self.is_remote
            )
        return (self.identifier << 21) | (self.is_remote << 20)

    @property
    def code(self) -> int:
        """The data length code."""
        if self.length_code >= 0:
            return self.length_code
        return FD_SIZES.index(len(self.data))


@dataclass(frozen=True, slots=True)
class BitTiming:
    """Bit rates of a bus."""

    bitrate: int = 1_000_000  # [bit/s]
    data_bitrate: int = 5_000_000  # [bit/s] of FD frames with bit-rate switch


def frame_duration(frame: BusFrame, timing: BitTiming) -> int:
    """Return how long ``frame`` and the gap after it keep the bus busy [ns]."""
    nominal, fast = frame_bits(frame)
    fast_rate = timing.data_bitrate if frame.has_bit_rate_switch else timing.bitrate
    return round(NS * (nominal / timing.bitrate + fast / fast_rate))


def frame_bits(frame: BusFrame) -> tuple[int, int]:
    """Return the number of bits at the nominal and at the data bit rate, stuff bits and gap included."""
    return _fd_bits(frame) if frame.fd else (_classic_bits(frame), 0)


def _classic_bits(frame: BusFrame) -> int:
    width, stuffed, run, crc = _classic_header(frame.identifier, frame.extended, frame.is_remote, frame.code)
    in_data, run = stuff_bytes(run, frame.data)
    in_crc, run = stuff_bit_by_bit(run, crc15_bytes(crc, frame.data), 15)
    last = run[1] == LONGEST_RUN
    return width + 8 * len(frame.data) + 15 + stuffed + in_data + in_crc + last + AFTER_CRC


@lru_cache(maxsize=4096)
def _classic_header(identifier: int, extended: bool, is_remote: bool, code: int) -> tuple[int, int, Run, int]:
    """Return width, stuff bits, run and CRC of the bits from start of frame to the length code."""
    if extended:  # SOF 0, 11 bits, SRR 1, IDE 1, 18 bits, RTR, r1 0, r0 0, DLC
        first, rest = identifier >> 18, identifier & 0x3FFFF
        bits, width = (first << 27) | (0b11 << 25) | (rest << 7) | (is_remote << 6) | code, 39
    else:  # SOF 0, 11 bits, RTR, IDE 0, r0 0, DLC
        bits, width = (identifier << 7) | (is_remote << 6) | code, 19
    stuffed, run = stuff_bit_by_bit(None, bits, width)
    return width, stuffed, run, crc15_bit_by_bit(0, bits, width)


def _fd_bits(frame: BusFrame) -> tuple[int, int]:
    nominal, fast, run = _fd_control(
        frame.identifier, frame.extended, frame.has_bit_rate_switch, frame.is_error_passive, frame.code
    )
    in_data, _ = stuff_bytes(
        run, frame.data
    )  # a run of five at its end is broken by the first fixed stuff bit
    return nominal, fast + in_data


@lru_cache(maxsize=4096)
def _fd_control(
    identifier: int, extended: bool, has_bit_rate_switch: bool, is_error_passive: bool, code: int
) -> tuple[int, int, Run]:
    """Return the bits at both bit rates, without those stuffed into the data, and the run before the data."""
    width, stuffed, run = _fd_header(identifier, extended, has_bit_rate_switch)
    in_control, run = stuff_bit_by_bit(run, (is_error_passive << 4) | code, 5)
    length = FD_SIZES[code]
    crc = 4 + (17 if length <= 16 else 21)
    fixed, delimiter = 1 + crc // 4, 1
    fast = 5 + in_control + 8 * length + crc + fixed + delimiter
    return width + stuffed + AFTER_CRC_FD, fast, run


@lru_cache(maxsize=4096)
def _fd_header(identifier: int, extended: bool, has_bit_rate_switch: bool) -> tuple[int, int, Run]:
    """Return width, stuff bits and run of the bits from start of frame to BRS."""
    if extended:  # SOF 0, 11 bits, SRR 1, IDE 1, 18 bits, RRS 0, FDF 1, res 0, BRS
        first, rest = identifier >> 18, identifier & 0x3FFFF
        bits, width = (first << 24) | (0b11 << 22) | (rest << 4) | (0b010 << 1) | has_bit_rate_switch, 36
    else:  # SOF 0, 11 bits, RRS 0, IDE 0, FDF 1, res 0, BRS
        bits, width = (identifier << 5) | (0b0010 << 1) | has_bit_rate_switch, 17
    stuffed, run = stuff_bit_by_bit(None, bits, width)
    return width, stuffed, run


@lru_cache(maxsize=1024)
def longest_duration(identifier: int, length: int, fd: bool, timing: BitTiming) -> int:
    """Return the duration [ns] that no standard data frame with this identifier and length exceeds.

    Classic: the bound of [DavisBurnsBrilLukkien2007]_. FD with bit-rate switch: the bits up to BRS are known
    from the identifier; after them a stuff bit follows at most every fourth bit.
    """
    if not fd:
        g = 34
        return round(NS * (g + 8 * length + 13 + (g + 8 * length - 1) // 4) / timing.bitrate)
    width, stuffed, (_, run) = _fd_header(identifier, False, True)
    after = 5 + 8 * length  # ESI, length code, data
    free = LONGEST_RUN - run  # bits that may follow before the first stuff bit
    stuff = 0 if after < free else 1 + (after - free) // (LONGEST_RUN - 1)
    crc = 4 + (17 if length <= 16 else 21)
    fast = after + stuff + crc + 1 + crc // 4 + 1
    return round(NS * ((width + stuffed + AFTER_CRC_FD) / timing.bitrate + fast / timing.data_bitrate))


def number_bits(number: int, width: int) -> list[int]:
    """Return the ``width`` lowest bits of ``number``, highest first."""
    return [(number >> position) & 1 for position in reversed(range(width))]


@lru_cache(maxsize=256)
def typical_duration(length: int, fd: bool, timing: BitTiming) -> int:
    """Return the duration [ns] of a standard frame with ``length`` bytes of random data.

    For estimates of the load where the exact count would cost more than it tells. A length that no frame has,
    as other programs on a bus in software may send, counts as the next one that CAN FD has.
    """
    length = next((size for size in FD_SIZES if size >= length), FD_SIZES[-1])
    generator = Random(length)  # noqa: S311 (no secret)
    frames = [
        BusFrame(generator.getrandbits(11), generator.randbytes(length), fd=fd, has_bit_rate_switch=fd)
        for _ in range(64)
    ]
    return round(sum(frame_duration(frame, timing) for frame in frames) / len(frames))
