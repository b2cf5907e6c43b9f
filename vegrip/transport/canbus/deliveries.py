"""What members ask for and are brought, byte by byte: requests in, numbered deliveries out.

The form of both is that of :mod:`vegrip.transport.canbus.hub_wire`; errors are told as SocketCAN does
(:mod:`vegrip.transport.canbus.error_report`).
"""

from vegrip.transport.canbus.bus import queue_frame
from vegrip.transport.canbus.bus_records import *
from vegrip.transport.canbus.error_report import *
from vegrip.transport.canbus.frame_bits import data_bytes
from vegrip.transport.canbus.outside import Bytes, copy_bytes, load, send, store

EXTENDED_KEY = 2147483648

# --- requests


def take_packet(bus: Bus, slot: int, length: int, now: int) -> bool:
    """Queue the requests of ``packet``; False: there is something else in it, and nothing is changed."""
    count = requests_in(bus.packet, length)
    if count == 0:
        return False
    at = 0
    frame = bus.asked
    for _ in range(count):
        read_frame(bus.packet, at + 8, frame)
        time = now
        if bus.packet[at + 7] < 128:
            time = load(bus.packet, at, 8)
        queue_frame(bus, slot, min(max(time, now - OLDEST_REQUEST), now), frame)
        at += REQUEST_BYTES + data_bytes(frame)
    return True


def requests_in(packet: Bytes, length: int) -> int:
    """Return how many requests a packet is made of; 0: there is something else in it."""
    at = 0
    count = 0
    while at < length:
        if length - at < REQUEST_BYTES:
            return 0
        flags = packet[at + 12]
        code = packet[at + 13]
        if flags > FRAME_FLAGS or code > (15 if flags & FD != 0 else 8):
            return 0
        if load(packet, at + 8, 4) >> (29 if flags & EXTENDED != 0 else 11) != 0:
            return 0
        at += REQUEST_BYTES
        if flags & REMOTE == 0:
            at += DATA_SIZES[code]
        count += 1
    return count if at == length else 0


def read_frame(packet: Bytes, at: int, frame: Frame) -> None:
    """Read identifier, flags, code and data."""
    frame.identifier = load(packet, at, 4)
    frame.flags = packet[at + 4]
    frame.code = packet[at + 5]
    copy_bytes(frame.data, 0, packet, at + 6, data_bytes(frame))


# --- deliveries


def bring_events(bus: Bus, now: int) -> None:
    """Bring what has happened to the members."""
    for number in range(bus.happened):
        event = bus.events[number]
        if event.kind == SENT:
            bring_frame(bus, bus.done, event.busy, now)
        elif event.kind == FAILED:
            bring_error(bus, bus.done, event.busy, now)
        elif bus.nodes[event.slot].descriptor >= 0:
            bring_state(bus, event, now)


def bring_frame(bus: Bus, sent: Attempt, busy: int, now: int) -> None:
    """Bring a frame to all that want it."""
    if sent.is_lost:
        return
    frame = sent.frame
    data = data_bytes(frame)
    write_head(bus.delivery, sent.end, busy, sent.number, frame.identifier, frame.flags, frame.code)
    copy_bytes(bus.delivery, DELIVERY_BYTES, frame.data, 0, data)
    key = frame.identifier
    if frame.flags & EXTENDED != 0:
        key = key | EXTENDED_KEY
    for place in range(bus.attached):
        slot = bus.order[place]
        node = bus.nodes[slot]
        if node.descriptor < 0 or not accepts(node, key):
            continue
        if node.hears_itself or (slot != sent.slot and node.number != sent.missed_by):
            bring(bus, slot, DELIVERY_BYTES + data, now)


def accepts(node: Node, key: int) -> bool:
    """Return whether a frame passes the filters of a member; without any it hears everything."""
    if node.filters == 0:
        return True
    for i in range(node.filters):
        if (key ^ node.pairs[2 * i]) & node.pairs[2 * i + 1] == 0:
            return True
    return False


def bring_error(bus: Bus, failed: Attempt, busy: int, now: int) -> None:
    """Bring every member what its controller says of an error."""
    for place in range(bus.attached):
        slot = bus.order[place]
        node = bus.nodes[slot]
        if node.descriptor < 0:
            continue
        sending = SENDING if slot == failed.slot else 0
        kind = OF_STUFFING | sending
        if failed.error == ACK_ERROR:
            kind = sending
        elif failed.error == BIT_ERROR and sending != 0:
            kind = OF_BIT | sending
        where = ACK_SLOT if failed.error == ACK_ERROR else IN_DATA
        classes = ACKNOWLEDGEMENT if failed.error == ACK_ERROR else PROTOCOL
        write_head(
            bus.delivery,
            failed.end,
            busy,
            node.number,
            classes | BUS_ERROR | HAS_COUNTERS,
            EXTENDED | ERROR,
            8,
        )
        write_detail(bus.delivery, 0, kind, where, node.transmit, node.receive)
        bring(bus, slot, DELIVERY_BYTES + 8, now)


def bring_state(bus: Bus, change: Event, now: int) -> None:
    """Bring a member what its controller says of its new state."""
    classes = CONTROLLER
    detail = TRANSMIT_PASSIVE if change.transmit >= change.receive else RECEIVE_PASSIVE
    if change.state == OFF:
        classes = BUS_OFF
        detail = 0
    elif change.state == ACTIVE:
        classes = CONTROLLER | RESTARTED if change.transmit + change.receive == 0 else CONTROLLER
        detail = ERROR_ACTIVE
    write_head(
        bus.delivery, change.time, change.busy, change.number, classes | HAS_COUNTERS, EXTENDED | ERROR, 8
    )
    write_detail(bus.delivery, detail, 0, 0, change.transmit, change.receive)
    bring(bus, change.slot, DELIVERY_BYTES + 8, now)


def write_head(d: Bytes, end: int, busy: int, number: int, identifier: int, flags: int, code: int) -> None:
    """Write a delivery up to its data, but for the number that it has for one member."""
    store(d, 4, end, 8)
    store(d, 12, busy, 8)
    store(d, 20, number, 2)
    store(d, 22, identifier, 4)
    store(d, 26, flags, 1)
    store(d, 27, code, 1)


def write_detail(d: Bytes, state: int, kind: int, where: int, transmit: int, receive: int) -> None:
    """Write the eight bytes of an error frame."""
    store(d, DELIVERY_BYTES, state << 8 | kind << 16 | where << 24, 6)
    store(d, DELIVERY_BYTES + 6, min(transmit, 255), 1)
    store(d, DELIVERY_BYTES + 7, min(receive, 255), 1)


def bring(bus: Bus, slot: int, size: int, now: int) -> None:
    """Bring ``delivery`` to a member: at once, or to what is gathered for it."""
    node = bus.nodes[slot]
    store(bus.delivery, 0, node.delivery, 4)
    node.delivery += 1
    if node.patience < 0:
        post(bus, slot, bus.delivery, size)
        return
    if node.gathered + size > GATHERED_BYTES:
        hand_out_to(bus, slot)
    if node.gathered == 0:
        node.due = now + node.patience
        bus.due = min(bus.due, node.due)
    copy_bytes(node.gathering, node.gathered, bus.delivery, 0, size)
    node.gathered += size


def post(bus: Bus, slot: int, packet: Bytes, size: int) -> None:
    """Send a packet, or leave it in the outbox where the member does not read."""
    node = bus.nodes[slot]
    if not node.is_behind and send(node.descriptor, packet, 0, size):
        return
    node.is_behind = True
    unsent = bus.packets[bus.unsent]
    unsent.slot = slot
    unsent.at = bus.outbox_bytes
    unsent.size = size
    copy_bytes(bus.outbox, bus.outbox_bytes, packet, 0, size)
    bus.outbox_bytes += size
    bus.unsent += 1


def has_room(bus: Bus) -> bool:
    """Return whether the outbox has room for what one frame, or handing out, can bring to all."""
    bytes_left = OUTBOX_BYTES - bus.outbox_bytes
    return UNSENT - bus.unsent >= 4 * bus.attached and bytes_left >= 2 * GATHERED_BYTES * bus.attached


def hand_out_to(bus: Bus, slot: int) -> None:
    """Hand out what is gathered for a member."""
    node = bus.nodes[slot]
    post(bus, slot, node.gathering, node.gathered)
    node.gathered = 0
    node.due = NO_EVENT


def hand_out(bus: Bus, now: int) -> None:
    """Hand out what was gathered for long enough."""
    if bus.due > now:
        return
    bus.due = NO_EVENT
    for place in range(bus.attached):
        slot = bus.order[place]
        if bus.nodes[slot].due <= now:
            hand_out_to(bus, slot)
        bus.due = min(bus.due, bus.nodes[slot].due)
