"""The loop of the bus process: wait, take requests, bring deliveries; it leaves where something is unusual.

The bytes of both are those of :mod:`vegrip.transport.canbus.hub_wire`; errors are reported as SocketCAN does.
"""

from vegrip.transport.canbus.bus import advance, conclude, next_event, queue_frame
from vegrip.transport.canbus.bus_records import *
from vegrip.transport.canbus.bus_records import (
    Bytes,
    clock,
    copy_bytes,
    load,
    look,
    receive,
    send,
    sleep_until,
    store,
)
from vegrip.transport.canbus.frame_bits import data_bytes

# why the loop has left
TIME = 0  # it has run for long enough, or a signal has come
NEWCOMER = 1  # there is something at the door
OTHER_PACKET = 2  # the member in slot ``who`` has sent ``length`` bytes that are not requests
GONE = 3  # the member in slot ``who`` has left
BEHIND = 4  # a member does not read; there is something in the outbox

EXTENDED_KEY = 2147483648


def carry(bus: Bus, until: int) -> int:  # noqa: PLR0911 (a reason each)
    """Carry frames until the time ``until`` [ns], or until something is out of the ordinary."""
    while True:
        if not wait(bus, until):
            return TIME
        now = clock()
        if conclude(bus, now):
            bring_events(bus, now)
        hand_out(bus, now)
        if bus.unsent > 0:
            return BEHIND
        for place in range(bus.attached):
            node = bus.nodes[bus.order[place]]
            bus.watched[place] = node.descriptor if node.waiting < TRANSMIT_QUEUE else -1
        members = bus.attached
        bus.watched[members] = bus.door
        if not look(bus.watched, bus.ready, members + 1, bus.patience):
            return TIME
        for place in range(members):
            if bus.ready[place] != 0:
                why = read(bus, bus.order[place])
                if why != TIME:
                    return why
        catch_up(bus)
        if bus.unsent > 0:
            return BEHIND
        if bus.ready[members] != 0:
            return NEWCOMER
        if now >= until:
            return TIME


def wait(bus: Bus, until: int) -> bool:
    """Sleep while a frame is on the bus; set for how long to wait for requests after it.

    Other requests for the bus matter only when it is free again: being woken by each of them meanwhile would
    cost more than all the rest. While frames wait behind the one on the bus, those that end within
    ``GATHERED`` are handed out at once: a wake-up, here and at each member, costs more than a frame. What the
    bus does when, and the times of the frames, do not change by that.

    Returns:
        Whether no signal has come.

    """
    now = clock()
    event = next_event(bus)
    if event == NO_EVENT:
        bus.patience = max(min(bus.due, until) - now, 0)
        return True
    bus.patience = 0
    if bus.queued > 1 and bus.troubled + bus.off + bus.faulty == 0:
        event += GATHERED
    return event <= now or sleep_until(min(event, now + LONGEST_SLEEP))


def read(bus: Bus, slot: int) -> int:
    """Read all that a member has sent; return why the loop must leave, or ``TIME``."""
    node = bus.nodes[slot]
    while node.waiting < TRANSMIT_QUEUE:
        length = receive(node.descriptor, bus.packet, PACKET_BYTES)
        if length < 0:
            return TIME
        bus.who = slot
        bus.length = length
        if length == 0:
            return GONE
        if not take_packet(bus, slot, length, clock()):
            return OTHER_PACKET
    return TIME


def catch_up(bus: Bus) -> None:
    """Bring the bus up to the present, or by a slice towards it when that is far, and hand out."""
    now = clock()
    limit = now
    event = next_event(bus)
    if event < now - SLICE:
        limit = event + SLICE
    while has_room(bus) and advance(bus, limit):
        bring_events(bus, now)
    if has_room(bus):
        hand_out(bus, now)


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
    """Return whether a frame passes the filters of a member; without any it receives everything."""
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
        if bus.nodes[slot].descriptor < 0:
            continue
        kind = SENDING if slot == failed.slot else 0
        if failed.error == ACK_ERROR:
            report(bus, slot, failed.end, busy, ACKNOWLEDGEMENT | BUS_ERROR, kind << 16 | ACK_SLOT << 24, now)
            continue
        kind = kind | (OF_BIT if failed.error == BIT_ERROR and kind != 0 else OF_STUFFING)
        report(bus, slot, failed.end, busy, PROTOCOL | BUS_ERROR, kind << 16 | IN_DATA << 24, now)


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
    report(bus, change.slot, change.time, change.busy, classes, detail << 8, now)


def report(bus: Bus, slot: int, time: int, busy: int, classes: int, detail: int, now: int) -> None:
    """Bring a member an error frame."""
    node = bus.nodes[slot]
    write_head(bus.delivery, time, busy, node.number, classes | HAS_COUNTERS, EXTENDED | ERROR, 8)
    store(bus.delivery, DELIVERY_BYTES, detail, 6)
    store(bus.delivery, DELIVERY_BYTES + 6, min(node.transmit, 255), 1)
    store(bus.delivery, DELIVERY_BYTES + 7, min(node.receive, 255), 1)
    bring(bus, slot, DELIVERY_BYTES + 8, now)


def write_head(d: Bytes, end: int, busy: int, number: int, identifier: int, flags: int, code: int) -> None:
    """Write a delivery up to its data, but for the number that it has for one member."""
    store(d, 4, end, 8)
    store(d, 12, busy, 8)
    store(d, 20, number, 2)
    store(d, 22, identifier, 4)
    store(d, 26, flags, 1)
    store(d, 27, code, 1)


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
