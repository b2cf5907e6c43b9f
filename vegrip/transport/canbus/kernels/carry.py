"""The bus from one frame to the next: what :class:`~vegrip.transport.canbus.bus_model.BusModel` does then."""

from vegrip.transport.canbus.kernels.deliveries import deliver, has_room
from vegrip.transport.canbus.kernels.frame_bits import frame_duration
from vegrip.transport.canbus.kernels.limits import NO_EVENT
from vegrip.transport.canbus.kernels.memory import (
    BUSY,
    CURRENT,
    END,
    FIRST,
    FRAME_BYTES,
    FRAMES,
    FREE,
    KEY,
    MEMBERS,
    NO_SLOT,
    NODE,
    QUEUE_PLACES,
    QUEUED,
    REQUEST_WHOLES,
    REQUESTS,
    SLOT,
    SLOTS,
    START,
    TIME,
    WAITING,
    Bytes,
    Wholes,
)


def next_event(t: Wholes) -> int:
    """Return when :func:`advance` will have something to do [ns]; ``NO_EVENT``: not before a request."""
    return t[END] if t[CURRENT] >= 0 else next_start(t)


def advance(t: Wholes, d: Bytes, until: int, now: int) -> int:
    """Let the time of the bus pass up to ``until`` [ns]; 1: packets must be sent before it can go on."""
    while True:
        if t[CURRENT] < 0:
            begin(t, d, until)
        if t[CURRENT] < 0 or t[END] > until:
            return 0
        if not has_room(t):
            return 1
        finish(t, d, now)


def conclude(t: Wholes, d: Bytes, now: int) -> None:
    """Finish the frame on the bus if it has ended by ``now`` [ns], but begin no other."""
    if t[CURRENT] >= 0 and t[END] <= now:
        finish(t, d, now)


def next_start(t: Wholes) -> int:
    """Return when the next frame begins [ns]; ``NO_EVENT``: none waits."""
    if t[QUEUED] == 0:
        return NO_EVENT
    earliest = NO_EVENT
    for slot in range(t[MEMBERS]):
        member = SLOTS + slot * SLOT
        if t[member + WAITING] > 0:
            number = slot * QUEUE_PLACES + t[member + FIRST]
            earliest = min(earliest, t[REQUESTS + number * REQUEST_WHOLES + TIME])
    return max(earliest, t[FREE])


def winner(t: Wholes, start: int) -> int:
    """Return the slot that wins the bus at ``start`` [ns]: of the lowest key, then of the lowest node."""
    found = NO_SLOT
    lowest = NO_EVENT
    for slot in range(t[MEMBERS]):
        member = SLOTS + slot * SLOT
        if t[member + WAITING] == 0:
            continue
        request = REQUESTS + (slot * QUEUE_PLACES + t[member + FIRST]) * REQUEST_WHOLES
        key = t[request + KEY] << 16 | t[member + NODE]
        if t[request + TIME] <= start and key < lowest:
            found = slot
            lowest = key
    return found


def begin(t: Wholes, d: Bytes, until: int) -> None:
    """Put the next frame on the free bus if its time has come."""
    start = next_start(t)
    if start > until:
        return
    slot = winner(t, start)
    frame = FRAMES + (slot * QUEUE_PLACES + t[SLOTS + slot * SLOT + FIRST]) * FRAME_BYTES
    t[CURRENT] = slot
    t[START] = start
    t[END] = start + frame_duration(t, d, frame)
    t[FREE] = t[END]


def finish(t: Wholes, d: Bytes, now: int) -> None:
    """Take the frame on the bus out of its queue and bring it to the members."""
    slot = t[CURRENT]
    member = SLOTS + slot * SLOT
    frame = FRAMES + (slot * QUEUE_PLACES + t[member + FIRST]) * FRAME_BYTES
    t[BUSY] += t[END] - t[START]
    deliver(t, d, slot, frame, now)
    t[member + FIRST] = (t[member + FIRST] + 1) % QUEUE_PLACES
    t[member + WAITING] -= 1
    t[QUEUED] -= 1
    t[CURRENT] = NO_SLOT
