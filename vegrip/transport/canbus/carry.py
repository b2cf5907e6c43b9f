"""The loop of the bus process: wait, receive, send; it leaves where something is out of the ordinary."""

from vegrip.transport.canbus.bus import advance, conclude, next_event
from vegrip.transport.canbus.bus_records import *
from vegrip.transport.canbus.deliveries import bring_events, hand_out, has_room, take_packet
from vegrip.transport.canbus.outside import clock, look, receive, sleep_until

# why the loop has left
TIME = 0  # it has run for long enough, or a signal has come
NEWCOMER = 1  # there is something at the door
OTHER_PACKET = 2  # the member in slot ``who`` has sent ``length`` bytes that are not requests
GONE = 3  # the member in slot ``who`` has left
BEHIND = 4  # a member does not read; there is something in the outbox


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
