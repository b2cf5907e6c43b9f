"""What members are brought: the numbered delivery of a frame, one by one or gathered."""

from vegrip.transport.canbus.kernels.frame_bits import FLAG_EXTENDED, data_bytes, identifier_of
from vegrip.transport.canbus.kernels.limits import NO_EVENT
from vegrip.transport.canbus.kernels.memory import (
    BUSY,
    BYTES_TO_SEND,
    DELIVERY_HEAD,
    DELIVERY_IDENTIFIER,
    DUE,
    END,
    FILTERS,
    FIRST_PAIR,
    FRAME_DATA,
    FRAME_FLAGS,
    GATHERED,
    GATHERED_BYTES,
    GATHERED_DUE,
    GATHERINGS,
    HEARS_ITSELF,
    MEMBERS,
    MOST_PACKETS,
    NODE,
    NUMBER,
    OUTBOX,
    OUTBOX_BYTES,
    PACKET_ENTRY,
    PACKETS,
    PAIRS,
    PATIENCE,
    SLOT,
    SLOTS,
    TO_SEND,
    TO_SEND_AT,
    TO_SEND_BYTES,
    TO_SLOT,
    Bytes,
    Wholes,
)

EXTENDED_KEY = 2147483648


def has_room(t: Wholes) -> bool:
    """Return whether another frame can be brought to all before packets are sent."""
    most = t[MEMBERS] * GATHERED_BYTES
    return t[PACKETS] + t[MEMBERS] <= MOST_PACKETS and t[BYTES_TO_SEND] + most <= OUTBOX_BYTES


def deliver(t: Wholes, d: Bytes, sender: int, frame: int, now: int) -> None:
    """Bring the frame at ``frame``, which has ended, to all that want it."""
    key = identifier_of(d, frame)
    if d[frame + FRAME_FLAGS] & FLAG_EXTENDED != 0:
        key = key | EXTENDED_KEY
    for slot in range(t[MEMBERS]):
        member = SLOTS + slot * SLOT
        if slot == sender and t[member + HEARS_ITSELF] == 0:
            continue
        if accepts(t, member, key):
            bring(t, d, slot, sender, frame, now)


def accepts(t: Wholes, member: int, key: int) -> bool:
    """Return whether a frame passes the filters of a member; without any it hears everything."""
    if t[member + PAIRS] == 0:
        return True
    pair = FILTERS + 2 * t[member + FIRST_PAIR]
    for _ in range(t[member + PAIRS]):
        if (key ^ t[pair]) & t[pair + 1] == 0:
            return True
        pair += 2
    return False


def bring(t: Wholes, d: Bytes, slot: int, sender: int, frame: int, now: int) -> None:
    """Bring the frame to the member ``slot``: at once, or to what is gathered for it."""
    member = SLOTS + slot * SLOT
    size = DELIVERY_HEAD + data_bytes(d, frame)
    if t[member + PATIENCE] < 0:
        pack(t, d, member, sender, frame, note_packet(t, slot, size))
        return
    if t[member + GATHERED] + size > GATHERED_BYTES:
        hand_out_to(t, d, slot)
    if t[member + GATHERED] == 0:
        t[member + GATHERED_DUE] = now + t[member + PATIENCE]
        t[DUE] = min(t[DUE], t[member + GATHERED_DUE])
    pack(t, d, member, sender, frame, GATHERINGS + slot * GATHERED_BYTES + t[member + GATHERED])
    t[member + GATHERED] += size


def pack(t: Wholes, d: Bytes, member: int, sender: int, frame: int, at: int) -> None:
    """Put the delivery with the member's next number at ``at``."""
    put(d, at, t[member + NUMBER], 4)
    put(d, at + 4, t[END], 8)
    put(d, at + 12, t[BUSY], 8)
    put(d, at + 20, t[SLOTS + sender * SLOT + NODE], 2)
    for i in range(FRAME_DATA + data_bytes(d, frame)):
        d[at + DELIVERY_IDENTIFIER + i] = d[frame + i]
    t[member + NUMBER] += 1


def put(d: Bytes, at: int, value: int, size: int) -> None:
    """Put a whole number of ``size`` bytes, the least significant byte first."""
    for i in range(size):
        d[at + i] = value >> 8 * i & 255


def note_packet(t: Wholes, slot: int, size: int) -> int:
    """Note a packet to be sent; return where its bytes go."""
    entry = TO_SEND + t[PACKETS] * PACKET_ENTRY
    at = OUTBOX + t[BYTES_TO_SEND]
    t[entry + TO_SLOT] = slot
    t[entry + TO_SEND_AT] = at
    t[entry + TO_SEND_BYTES] = size
    t[PACKETS] += 1
    t[BYTES_TO_SEND] += size
    return at


def hand_out_to(t: Wholes, d: Bytes, slot: int) -> None:
    """Hand out what is gathered for a member."""
    member = SLOTS + slot * SLOT
    at = note_packet(t, slot, t[member + GATHERED])
    for i in range(t[member + GATHERED]):
        d[at + i] = d[GATHERINGS + slot * GATHERED_BYTES + i]
    t[member + GATHERED] = 0
    t[member + GATHERED_DUE] = NO_EVENT


def hand_out(t: Wholes, d: Bytes, now: int) -> None:
    """Hand out what was gathered for long enough."""
    if t[DUE] > now:
        return
    due = NO_EVENT
    for slot in range(t[MEMBERS]):
        member = SLOTS + slot * SLOT
        if t[member + GATHERED_DUE] <= now:
            hand_out_to(t, d, slot)
        due = min(due, t[member + GATHERED_DUE])
    t[DUE] = due
