"""A packet of a member becomes requests in its queue; only what is ordinary throughout is taken."""

from vegrip.transport.canbus.kernels.frame_bits import (
    ALL_FLAGS,
    FLAG_EXTENDED,
    FLAG_FD,
    FLAG_REMOTE,
    data_bytes,
    identifier_of,
)
from vegrip.transport.canbus.kernels.frame_fields import DATA_SIZES
from vegrip.transport.canbus.kernels.limits import OLDEST_REQUEST
from vegrip.transport.canbus.kernels.memory import (
    FIRST,
    FRAME_BYTES,
    FRAME_CODE,
    FRAME_DATA,
    FRAME_FLAGS,
    FRAMES,
    KEY,
    LISTENS_ONLY,
    QUEUE_PLACES,
    QUEUED,
    RECEIVED,
    REQUEST_HEAD,
    REQUEST_IDENTIFIER,
    REQUEST_WHOLES,
    REQUESTS,
    SLOT,
    SLOTS,
    TIME,
    WAITING,
    Bytes,
    Wholes,
)


def take_packet(t: Wholes, d: Bytes, slot: int, length: int, now: int) -> int:
    """Queue the requests of the packet at ``RECEIVED``; 0: it is for Python, and nothing is changed."""
    count = requests_in(d, length)
    member = SLOTS + slot * SLOT
    if count == 0 or t[member + WAITING] + count > QUEUE_PLACES:
        return 0
    if t[member + LISTENS_ONLY] != 0:
        return 1
    at = RECEIVED
    for _ in range(count):
        queue_request(t, d, slot, at, now)
        at += REQUEST_HEAD + data_bytes(d, at + REQUEST_IDENTIFIER)
    return 1


def requests_in(d: Bytes, length: int) -> int:
    """Return how many requests the packet holds; 0: there is something else in it."""
    at = RECEIVED
    end = RECEIVED + length
    count = 0
    while at < end:
        if end - at < REQUEST_HEAD:
            return 0
        frame = at + REQUEST_IDENTIFIER
        if not is_frame(d, frame):
            return 0
        if d[frame + FRAME_FLAGS] & FLAG_REMOTE != 0:  # together with others they are for Python
            return 1 if length == REQUEST_HEAD else 0
        at += REQUEST_HEAD + DATA_SIZES[d[frame + FRAME_CODE] & 15]
        count += 1
    return count if at == end else 0


def is_frame(d: Bytes, frame: int) -> bool:
    """Return whether identifier, flags and length code are those of a frame."""
    flags = d[frame + FRAME_FLAGS]
    if flags > ALL_FLAGS or d[frame + FRAME_CODE] > (15 if flags & FLAG_FD != 0 else 8):
        return False
    return identifier_of(d, frame) >> (29 if flags & FLAG_EXTENDED != 0 else 11) == 0


def queue_request(t: Wholes, d: Bytes, slot: int, at: int, now: int) -> None:
    """Queue the request at ``at``."""
    member = SLOTS + slot * SLOT
    if t[member + WAITING] == 0:
        t[member + FIRST] = 0  # so that the same memory is used again
    number = slot * QUEUE_PLACES + (t[member + FIRST] + t[member + WAITING]) % QUEUE_PLACES
    frame = FRAMES + number * FRAME_BYTES
    for i in range(FRAME_DATA + data_bytes(d, at + REQUEST_IDENTIFIER)):
        d[frame + i] = d[at + REQUEST_IDENTIFIER + i]
    t[REQUESTS + number * REQUEST_WHOLES + TIME] = time_of(d, at, now)
    t[REQUESTS + number * REQUEST_WHOLES + KEY] = arbitration_key(d, frame)
    t[member + WAITING] += 1
    t[QUEUED] += 1


def time_of(d: Bytes, at: int, now: int) -> int:
    """Return when the request at ``at`` says it was queued [ns], as far as that is credible."""
    if d[at + 7] >= 128:
        return now
    time = d[at + 7]
    for i in range(6, -1, -1):
        time = time << 8 | d[at + i]
    return min(max(time, now - OLDEST_REQUEST), now)


def arbitration_key(d: Bytes, frame: int) -> int:
    """Return the arbitration field as a number; the lower one wins the bus."""
    identifier = identifier_of(d, frame)
    remote = d[frame + FRAME_FLAGS] >> 1 & 1
    if d[frame + FRAME_FLAGS] & FLAG_EXTENDED != 0:
        return identifier >> 18 << 21 | 3 << 19 | (identifier & 262143) << 1 | remote
    return identifier << 21 | remote << 20
