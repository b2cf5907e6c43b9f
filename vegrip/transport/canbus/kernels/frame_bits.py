"""How long a frame occupies the bus: :mod:`vegrip.transport.canbus.frame_time` over bytes."""

from vegrip.transport.canbus.kernels.frame_fields import AFTER_CRC, AFTER_CRC_FD, DATA_SIZES
from vegrip.transport.canbus.kernels.memory import (
    BITRATE,
    DATA_BITRATE,
    FRAME_CODE,
    FRAME_DATA,
    FRAME_FLAGS,
    Bytes,
    Wholes,
)
from vegrip.transport.canbus.kernels.stuffing_tables import (
    CRC15_OF_BYTE,
    GENERATOR,
    NO_RUN,
    RUN_AFTER,
    RUNS,
    STUFFED,
    UNBROKEN,
)

FLAG_EXTENDED = 1
FLAG_REMOTE = 2
FLAG_FD = 4
FLAG_SWITCH = 8
FLAG_PASSIVE = 16
ALL_FLAGS = 31


def frame_duration(t: Wholes, d: Bytes, frame: int) -> int:
    """Return how long the frame at ``frame`` and the gap after it keep the bus busy [ns]."""
    nominal, fast = frame_bits(d, frame)
    rate = float(t[BITRATE])
    fast_rate = float(t[DATA_BITRATE]) if d[frame + FRAME_FLAGS] & FLAG_SWITCH != 0 else rate
    return round(1e9 * (float(nominal) / rate + float(fast) / fast_rate))


def frame_bits(d: Bytes, frame: int) -> tuple[int, int]:
    """Return the number of bits at the nominal and at the data bit rate, stuff bits and gap included."""
    if d[frame + FRAME_FLAGS] & FLAG_FD != 0:
        return fd_bits(d, frame)
    return classic_bits(d, frame), 0


def classic_bits(d: Bytes, frame: int) -> int:
    """Return the number of bits of a classic frame."""
    remote = d[frame + FRAME_FLAGS] >> 1 & 1
    code = d[frame + FRAME_CODE] & 15
    identifier = identifier_of(d, frame)
    if d[frame + FRAME_FLAGS] & FLAG_EXTENDED != 0:
        width = 39
        bits = identifier >> 18 << 27 | 3 << 25 | (identifier & 262143) << 7 | remote << 6 | code
    else:
        width = 19
        bits = identifier << 7 | remote << 6 | code
    total, run = stuff_bits(NO_RUN, bits, width)
    crc = 0
    for position in range(width - 1, -1, -1):
        inverted = (bits >> position ^ crc >> 14) & 1
        crc = crc << 1 & 32767
        if inverted == 1:
            crc = crc ^ GENERATOR
    length = data_bytes(d, frame)
    for i in range(length):
        byte = d[frame + FRAME_DATA + i]
        total += STUFFED[256 * run + byte]
        run = RUN_AFTER[256 * run + byte]
        crc = crc << 8 & 32767 ^ CRC15_OF_BYTE[(crc >> 7 ^ byte) & 255]
    in_crc, run = stuff_bits(run, crc, 15)
    last = 1 if run % RUNS == UNBROKEN - 1 else 0
    return width + 8 * length + 15 + total + in_crc + last + AFTER_CRC


def fd_bits(d: Bytes, frame: int) -> tuple[int, int]:
    """Return the numbers of bits of a CAN FD frame."""
    flags = d[frame + FRAME_FLAGS] & ALL_FLAGS
    code = d[frame + FRAME_CODE] & 15
    identifier = identifier_of(d, frame)
    switch = flags >> 3 & 1
    if flags & FLAG_EXTENDED != 0:
        width = 36
        bits = identifier >> 18 << 24 | 3 << 22 | (identifier & 262143) << 4 | 4 | switch
    else:
        width = 17
        bits = identifier << 5 | 4 | switch
    in_header, run = stuff_bits(NO_RUN, bits, width)
    in_rest, run = stuff_bits(run, flags & FLAG_PASSIVE | code, 5)
    for i in range(data_bytes(d, frame)):
        byte = d[frame + FRAME_DATA + i]
        in_rest += STUFFED[256 * run + byte]
        run = RUN_AFTER[256 * run + byte]
    length = DATA_SIZES[code]
    crc = 21 if length <= 16 else 25
    return width + in_header + AFTER_CRC_FD, 5 + in_rest + 8 * length + crc + 1 + crc // 4 + 1


def stuff_bits(run: int, bits: int, width: int) -> tuple[int, int]:
    """Send the ``width`` lowest ``bits``, highest first; return how many were stuffed in, and the run."""
    stuffed = 0
    value = -1
    length = 0
    if run >= 0:
        value = run // RUNS
        length = run % RUNS + 1
    for position in range(width - 1, -1, -1):
        bit = bits >> position & 1
        if length == UNBROKEN:
            stuffed += 1
            value = 1 - value
            length = 1
        if bit == value:
            length += 1
        else:
            value = bit
            length = 1
    return stuffed, RUNS * value + length - 1


def data_bytes(d: Bytes, frame: int) -> int:
    """Return how many bytes of data the frame has."""
    return 0 if d[frame + FRAME_FLAGS] & FLAG_REMOTE != 0 else DATA_SIZES[d[frame + FRAME_CODE] & 15]


def identifier_of(d: Bytes, frame: int) -> int:
    """Return the identifier of the frame."""
    return d[frame] | d[frame + 1] << 8 | d[frame + 2] << 16 | d[frame + 3] << 24
