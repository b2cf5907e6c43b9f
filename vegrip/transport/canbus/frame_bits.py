"""The bits of a CAN frame, one by one or counted, and how long good and bad frames occupy the bus [ISO2015]_.

Classic CAN: start of frame to the end of the CRC is stuffed: after five equal bits comes one of the opposite
value, which itself begins the next run. Then follow CRC delimiter, acknowledgement and its delimiter, 7 bits
end of frame, 3 bits between frames. CAN FD: start of frame to the end of the data is stuffed; the CRC field
(stuff count 4, CRC 17 or 21) has fixed stuff bits instead, one in front and one after every fourth bit.
From the bit after BRS to the CRC delimiter the data bit rate holds [BordoloiSamii2014]_. (Exactly, the rate
changes at the sample points of BRS and of the CRC delimiter; here it changes at their ends.)

A node that finds an error sends six equal bits at once. They break the rule of stuffing, so that every other
node finds an error after ``6 - r`` more bits at the latest, ``r`` being the run of such bits that stands on
the bus already, and sends its own flag::

    bits up to the error | flag 6 | answer 6 - r | delimiter 8 | between frames 3 | error-passive sender 8

which is 17 to 23 bits after the error, and at most 31 until an error-passive sender may begin again, as
[Bosch1991]_ says. The sender itself notices a flag by the first recessive bit it sends. An error-active node
sends dominant bits, an error-passive one recessive bits: when it is the sender, they break the rule too.
Flags have the nominal bit rate; in the data phase of an FD frame the others count at the data bit rate until
they notice. Left out: error-passive nodes that answer an active flag stretch nothing here; errors in
arbitration or after the data are not made.
"""

from vegrip.transport.canbus.bus_records import *

AFTER_CRC = 1 + 1 + 1 + 7 + 3  # CRC delimiter, ACK, ACK delimiter, end of frame, between frames
AFTER_CRC_FD = AFTER_CRC - 1  # the CRC delimiter is sent at the data bit rate
FLAG = 6
SIGNALLING = FLAG + 8 + 3  # flag, delimiter, between frames
UNACKNOWLEDGED = SIGNALLING - (1 + 7 + 3)  # in place of delimiter, end of frame, between frames
SUSPENSION = 8  # bits for which an error-passive sender waits after the gap between frames


def data_bytes(frame: Frame) -> int:
    return 0 if frame.flags & REMOTE != 0 else DATA_SIZES[frame.code & 15]


def arbitration_key(frame: Frame) -> int:
    """Return the arbitration field as a number; the lower one wins the bus.

    11 bits, RTR (or SRR of an extended frame, recessive), IDE, 18 bits, RTR: a standard frame beats the
    extended one of equal first bits, a data frame the remote one.
    """
    identifier = frame.identifier
    remote = frame.flags >> 1 & 1
    if frame.flags & EXTENDED != 0:
        return identifier >> 18 << 21 | 3 << 19 | (identifier & 262143) << 1 | remote
    return identifier << 21 | remote << 20


def head(frame: Frame) -> tuple[int, int]:
    """Return the bits from start of frame to the end of arbitration as a number, and how many there are."""
    identifier = frame.identifier
    remote = frame.flags >> 1 & 1 if frame.flags & FD == 0 else 0
    if frame.flags & EXTENDED != 0:  # SOF 0, 11 bits, SRR 1, IDE 1, 18 bits, RTR
        return identifier >> 18 << 21 | 3 << 19 | (identifier & 262143) << 1 | remote, 33
    return identifier << 1 | remote, 13  # SOF 0, 11 bits, RTR


def control(frame: Frame) -> tuple[int, int]:
    """Return the bits that follow, to the length code (FD: to BRS)."""
    if frame.flags & FD == 0:
        return frame.code & 15, 6  # IDE r0, or r1 r0, then the code
    bits = 4 | frame.flags >> 3 & 1  # (IDE 0) FDF 1 res 0 BRS
    return bits, 3 if frame.flags & EXTENDED != 0 else 4


def stuff_bits(run: int, bits: int, width: int) -> tuple[int, int]:
    """Send the ``width`` lowest ``bits``, highest first; return how many were stuffed in, and the run.

    A run of five at the end is returned unbroken: whether a stuff bit follows is for the next field to say.
    """
    stuffed = 0
    value = -1
    length = 0
    if run >= 0:
        value = run // RUNS
        length = run % RUNS + 1
    for position in range(width - 1, -1, -1):
        bit = bits >> position & 1
        if length == LONGEST_RUN:
            stuffed += 1
            value = 1 - value
            length = 1
        if bit == value:
            length += 1
        else:
            value = bit
            length = 1
    return stuffed, RUNS * value + length - 1


def crc15_bits(crc: int, bits: int, width: int) -> int:
    """Take the ``width`` lowest ``bits`` into ``crc``, highest first."""
    found = crc
    for position in range(width - 1, -1, -1):
        inverted = (bits >> position ^ found >> 14) & 1
        found = found << 1 & 32767
        if inverted == 1:
            found = found ^ CRC15
    return found


def crc15(frame: Frame) -> int:
    """Return the CRC of a classic frame."""
    bits, width = head(frame)
    crc = crc15_bits(0, bits, width)
    bits, width = control(frame)
    crc = crc15_bits(crc, bits, width)
    for i in range(data_bytes(frame)):
        crc = crc << 8 & 32767 ^ CRC15_OF_BYTE[(crc >> 7 ^ frame.data[i]) & 255]
    return crc


def header_bits(frame: Frame) -> tuple[int, int]:
    """Return how many bits there are to the length code (FD: to BRS), and the run at their end."""
    bits, width = head(frame)
    in_head, run = stuff_bits(NO_RUN, bits, width)
    bits, more = control(frame)
    in_control, run = stuff_bits(run, bits, more)
    return width + more + in_head + in_control, run


def frame_bits(frame: Frame) -> tuple[int, int]:
    """Return the number of bits at the nominal and at the data bit rate, stuff bits and gap included."""
    slow, run = header_bits(frame)
    length = data_bytes(frame)
    fast = 0
    if frame.flags & FD != 0:
        fast, run = stuff_bits(run, frame.flags & ERROR_STATE | frame.code & 15, 5)  # ESI, code
    for i in range(length):
        byte = frame.data[i]
        fast += STUFFED[256 * run + byte]
        run = RUN_AFTER[256 * run + byte]
    if frame.flags & FD != 0:
        size = DATA_SIZES[frame.code & 15]
        crc = 21 if size <= 16 else 25  # with the stuff count
        return slow + AFTER_CRC_FD, 5 + fast + 8 * size + crc + 1 + crc // 4 + 1
    in_crc, run = stuff_bits(run, crc15(frame), 15)
    last = 1 if run % RUNS == LONGEST_RUN - 1 else 0
    return slow + 8 * length + fast + 15 + in_crc + last + AFTER_CRC, 0


def duration(nominal: int, fast: int, bitrate: int, data_bitrate: int) -> int:
    """Return how long so many bits take [ns]."""
    return round(1e9 * (float(nominal) / float(bitrate) + float(fast) / float(data_bitrate)))


def frame_duration(frame: Frame, bitrate: int, data_bitrate: int) -> int:
    """Return how long the frame and the gap after it keep the bus busy [ns]."""
    nominal, fast = frame_bits(frame)
    return duration(nominal, fast, bitrate, data_bitrate if frame.flags & SWITCH != 0 else bitrate)


def unacknowledged_duration(frame: Frame, bitrate: int, data_bitrate: int) -> int:
    """Return the time [ns] from the start of a frame that no node acknowledged to the end of the gap."""
    return frame_duration(frame, bitrate, data_bitrate) + bits_duration(UNACKNOWLEDGED, bitrate)


def bits_duration(bits: int, bitrate: int) -> int:
    """Return how long so many bits of nominal rate take [ns]."""
    return round(1e9 * float(bits) / float(bitrate))


# --- frames that go wrong


def append_bits(stream: Stream, bits: int, width: int) -> None:
    """Send the ``width`` lowest ``bits``, highest first, with the stuff bits before them."""
    for position in range(width - 1, -1, -1):
        last = 2
        if stream.count > 0:
            last = stream.bits[stream.count - 1]
        if stream.run == LONGEST_RUN:
            last = 1 - last
            stream.bits[stream.count] = last
            stream.count += 1
            stream.run = 1
        bit = bits >> position & 1
        stream.run = stream.run + 1 if bit == last else 1
        stream.bits[stream.count] = bit
        stream.count += 1


def write_stream(stream: Stream, frame: Frame) -> None:
    """Write the bits of ``frame``."""
    stream.count = 0
    stream.run = 0
    bits, width = head(frame)
    append_bits(stream, bits, width)
    stream.first = stream.count
    bits, width = control(frame)
    append_bits(stream, bits, width)
    stream.slow = stream.count
    is_fd = frame.flags & FD != 0
    if is_fd:
        append_bits(stream, frame.flags & ERROR_STATE | frame.code & 15, 5)
    for i in range(data_bytes(frame)):
        append_bits(stream, frame.data[i], 8)
    if is_fd:  # fixed stuff bits follow, which break a flag sooner
        stream.last = max(stream.first, stream.count - 1 - FLAG)
    else:
        stream.last = max(stream.first, stream.count - 1)
        append_bits(stream, crc15(frame), 15)
    if frame.flags & SWITCH == 0 or not is_fd:
        stream.slow = stream.count


def notice_bits(stream: Stream, position: int, is_alone: bool, is_passive: bool, is_answered: bool) -> int:
    """Return how many bits after the one who found an error the last node sends its flag.

    Args:
        stream: the frame.
        position: of the bit in which it is found.
        is_alone: one receiver finds it; else all nodes see the bit inverted, and the sender finds it.
        is_passive: the sender is error passive.
        is_answered: there are other receivers.

    """
    value = stream.bits[position]
    if not is_alone:
        value = 1 - value
    run = 1
    while run <= position and stream.bits[position - run] == value:
        run += 1
    if run > LONGEST_RUN:  # six equal bits: all found it in the same bit
        return 0
    if not is_answered:
        return bits_until_recessive(stream, position) if is_alone else 0
    flag = 1 if is_passive and not is_alone else 0
    return FLAG - run if value == flag else FLAG


def bits_until_recessive(stream: Stream, position: int) -> int:
    """Return how many bits after ``position`` the sender next sends a recessive bit."""
    bits = 1
    while position + bits < stream.count and stream.bits[position + bits] == 0:
        bits += 1
    return bits


def error_duration(
    stream: Stream,
    position: int,
    is_alone: bool,
    is_passive: bool,
    is_answered: bool,
    bitrate: int,
    data_bitrate: int,
) -> int:
    """Return the time [ns] from the start of a frame to the end of the gap after its error frame."""
    notice = notice_bits(stream, position, is_alone, is_passive, is_answered)
    slow = min(position + 1, stream.slow)
    fast = position + 1 - slow
    if fast > 0:
        return duration(slow + SIGNALLING, fast + notice, bitrate, data_bitrate)
    return duration(slow + SIGNALLING + notice, 0, bitrate, data_bitrate)
