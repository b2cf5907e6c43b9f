"""How long a CAN frame that goes wrong occupies the bus [ISO2015]_.

A node that finds an error sends six equal bits at once. They break the rule of stuffing, so that every
other node finds an error after ``6 - r`` more bits at the latest, ``r`` being the run of such bits that
stands on the bus already, and sends its own flag::

    bits up to the error | flag 6 | answer 6 - r | delimiter 8 | between frames 3 | error-passive sender 8

which is 17 to 23 bits after the error, and at most 31 until an error-passive sender may begin again, as
[Bosch1991]_ says. The sender itself notices a flag by the first recessive bit it sends. An error-active node
sends dominant bits, an error-passive one recessive bits: when it is the sender, they break the rule too.
Flags have the nominal bit rate; in the data phase of an FD frame the others count at the data bit rate until
they notice.

Left out: error-passive nodes that answer an active flag stretch nothing here; errors in arbitration or after
the data are not made.
"""

from typing import NamedTuple

from vegrip.clock import NS
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame, frame_duration, number_bits
from vegrip.transport.canbus.kernels.bit_stuffing import LONGEST_RUN, crc15_bit_by_bit

FLAG = 6
DELIMITER = 8
BETWEEN_FRAMES = 3
SUSPENSION = 8
"""Bits for which an error-passive sender waits after the gap between frames."""

_AFTER_ACK_SLOT = 1 + 7 + 3  # delimiter, end of frame, between frames


class BitStream(NamedTuple):
    """The bits of a frame on the bus, stuff bits included, up to the end of the CRC (FD: of the data)."""

    bits: list[int]
    slow: int  # how many of them have the nominal bit rate
    first: int  # position of the first bit after the arbitration field
    last: int  # and of the last bit of data (FD: that is followed by six more)

    def run(self, position: int, flipped: bool) -> tuple[int, int]:
        """Return the value on the bus at ``position`` and how many equal bits end there."""
        value = self.bits[position] ^ flipped
        run = 1
        while run <= position and self.bits[position - run] == value:
            run += 1
        return value, run

    def until_recessive(self, position: int) -> int:
        """Return how many bits after ``position`` the sender next sends a recessive bit."""
        return self.bits.index(1, position + 1) - position


class Error(NamedTuple):
    """How an error is found and answered."""

    position: int  # of the bit in which it is found
    found_by_one: bool  # one receiver finds it; else all nodes see the bit inverted, and the sender finds it
    is_passive: bool  # the sender is error passive
    answered: bool  # there are other receivers


def bit_stream(frame: BusFrame) -> BitStream:
    """Return the bits of ``frame``."""
    head, control = _head(frame), _control(frame)
    data = [bit for byte in frame.data for bit in number_bits(byte, 8)]
    until_data = [*head, *control, *data]
    first, ends = len(_stuffed(head)), len(_stuffed(until_data))
    if frame.fd:  # fixed stuff bits follow, which break a flag sooner
        bits = _stuffed(until_data)
        slow = len(_stuffed([*head, *control[:-5]])) if frame.has_bit_rate_switch else len(bits)
        return BitStream(bits, slow, first, max(first, ends - 1 - FLAG))
    bits = _stuffed([*until_data, *number_bits(_crc(until_data), 15)])
    return BitStream(bits, len(bits), first, max(first, ends - 1))


def notice_bits(stream: BitStream, error: Error) -> int:
    """Return how many bits after the one who found ``error`` the last node sends its flag."""
    value, run = stream.run(error.position, flipped=not error.found_by_one)
    if run > LONGEST_RUN:  # six equal bits: all found it in the same bit
        return 0
    if not error.answered:
        return stream.until_recessive(error.position) if error.found_by_one else 0
    flag = int(error.is_passive and not error.found_by_one)
    return FLAG - (run if value == flag else 0)


def error_duration(stream: BitStream, error: Error, timing: BitTiming) -> int:
    """Return the time [ns] from the start of a frame to the end of the gap after its error frame."""
    notice, before = notice_bits(stream, error), min(error.position + 1, stream.slow)
    nominal = before + FLAG + DELIMITER + BETWEEN_FRAMES
    at_data_rate = error.position + 1 - before
    if at_data_rate:
        at_data_rate += notice
    else:
        nominal += notice
    return round(NS * (nominal / timing.bitrate + at_data_rate / timing.data_bitrate))


def unacknowledged_duration(frame: BusFrame, timing: BitTiming) -> int:
    """Return the time [ns] from the start of a frame that no node acknowledged to the end of the gap."""
    signalling = FLAG + DELIMITER + BETWEEN_FRAMES - _AFTER_ACK_SLOT
    return frame_duration(frame, timing) + round(NS * signalling / timing.bitrate)


def suspension(timing: BitTiming) -> int:
    """Return how long an error-passive sender waits beyond the gap [ns]."""
    return round(NS * SUSPENSION / timing.bitrate)


def _crc(bits: list[int]) -> int:
    return crc15_bit_by_bit(0, int("".join(map(str, bits)), 2), len(bits))


def _head(frame: BusFrame) -> list[int]:
    remote = int(frame.is_remote)
    if frame.extended:
        first, rest = frame.identifier >> 18, frame.identifier & 0x3FFFF
        return [0, *number_bits(first, 11), 1, 1, *number_bits(rest, 18), remote]
    return [0, *number_bits(frame.identifier, 11), remote]


def _control(frame: BusFrame) -> list[int]:
    code = number_bits(frame.code, 4)
    if frame.fd:  # (IDE) FDF res BRS ESI
        format_bits = [1, 0] if frame.extended else [0, 1, 0]
        return [*format_bits, int(frame.has_bit_rate_switch), int(frame.is_error_passive), *code]
    return [0, 0, *code]  # IDE r0, or r1 r0


def _stuffed(bits: list[int]) -> list[int]:
    out: list[int] = []
    run = 0
    for bit in bits:
        if run == LONGEST_RUN:
            out.append(1 - out[-1])
            run = 1
        run = run + 1 if out and out[-1] == bit else 1
        out.append(bit)
    return out
