"""A CAN bus from one frame to the next: arbitration, time, errors, confinement, faults on purpose.

One text, run as it stands and in C (:mod:`vegrip.transport.canbus.compiled_bus`). Time comes in. Each node
sends its own frames in the order it queued them, as a SocketCAN transmit queue does; among the first frames
of all nodes the lowest arbitration field wins. What happens to a frame is settled when it begins, since a
node that joins later cannot receive it. A frame that goes wrong stays first in its node's queue and asks for
the bus again.

Fault confinement [ISO2015]_:

===========================================  =======================================================
what happens                                 counter
===========================================  =======================================================
a sender sends an error flag                 transmit + 8
the same for want of an acknowledgement,     unchanged: a lone node never goes bus-off
by an error-passive sender
a receiver finds an error                    receive + 1
it was the first to: others answer its flag  receive + 8 more
a frame was sent                             transmit - 1
a frame was received                         receive - 1, and from above 127 to 127
===========================================  =======================================================

Error passive when a counter exceeds 127, bus-off when the transmit counter exceeds 255. A node that is off
recovers, error active with both at zero, after 128 times 11 recessive bits.
"""

from vegrip.transport.canbus.bus_records import *
from vegrip.transport.canbus.bus_records import nearest
from vegrip.transport.canbus.frame_bits import (
    SUSPENSION,
    arbitration_key,
    bits_duration,
    data_bytes,
    error_duration,
    frame_duration,
    unacknowledged_duration,
    write_stream,
)  # fmt: skip

PASSIVE_LIMIT = 127
OFF_LIMIT = 255
RECOVERY_SEQUENCES = 128
RECOVERY_BITS_NS = 11_000_000_000  # [ns bit/s]


def next_event(bus: Bus) -> int:
    """Return when :func:`advance` has something to do [ns]; ``NO_EVENT``: not before the next request."""
    if bus.current.slot >= 0:
        return NO_EVENT if bus.is_hopeless else bus.current.end
    earliest = next_start(bus)
    if bus.off > 0:
        for place in range(bus.attached):
            node = bus.nodes[bus.order[place]]
            if node.state == OFF:
                earliest = min(earliest, recovery(bus, node))
    return earliest


def advance(bus: Bus, until: int) -> bool:
    """Let time pass to what happens next; False: nothing does up to ``until`` [ns].

    What has happened is in ``events``, a frame that was carried in ``done``.
    """
    bus.happened = 0
    if bus.is_hopeless:
        repeat_until(bus, until)
    if bus.off > 0 and bus.current.slot < 0:
        recover(bus, until)
        if bus.happened > 0:
            return True
    if bus.current.slot < 0:
        begin(bus, until)
    if bus.current.slot < 0 or bus.current.end > until:
        return False
    finish(bus)
    return True


def conclude(bus: Bus, now: int) -> bool:
    """Finish the frame on the bus if it has ended by ``now`` [ns], but begin no other.

    For members that must know of it before the next arbitration.
    """
    bus.happened = 0
    if bus.current.slot >= 0 and bus.current.end <= now and not bus.is_hopeless:
        finish(bus)
    return bus.happened > 0


# --- arbitration


def queue_frame(bus: Bus, slot: int, time: int, frame: Frame) -> bool:
    """Let a node send ``frame`` at ``time`` [ns]; refused of one that is off or listens, and without room."""
    node = bus.nodes[slot]
    if node.listens_only or node.state == OFF:
        return False
    late = 0
    if node.has_faults:
        late = delay(node.faults)
    bus.is_hopeless = False
    return append_request(bus, node, time + late, frame)


def append_request(bus: Bus, node: Node, time: int, frame: Frame) -> bool:
    """Put ``frame`` at the end of the queue of ``node``."""
    found = bus.unused
    if found >= 0:
        bus.unused = bus.requests[found].next
    elif bus.never_used < REQUESTS:
        found = bus.never_used
        bus.never_used += 1
    else:
        return False
    request = bus.requests[found]
    request.time = time
    request.key = arbitration_key(frame)
    request.frame = frame
    if node.waiting == 0:
        node.first = found
    else:
        bus.requests[node.last].next = found
    node.last = found
    node.waiting += 1
    bus.queued += 1
    return True


def remove_first(bus: Bus, node: Node) -> None:
    """Take the first frame of ``node`` out of its queue."""
    found = node.first
    node.first = bus.requests[found].next
    bus.requests[found].next = bus.unused
    bus.unused = found
    node.waiting -= 1
    bus.queued -= 1


def drop(bus: Bus, node: Node) -> int:
    """Forget the frames of ``node``; return how many there were."""
    dropped = node.waiting
    node.suspended = LONG_AGO
    while node.waiting > 0:
        remove_first(bus, node)
    return dropped


def ready(bus: Bus, node: Node) -> int:
    """Return from when on ``node`` asks for the bus with its first frame [ns]."""
    return max(bus.requests[node.first].time, node.suspended)


def next_start(bus: Bus) -> int:
    """Return when the next frame begins [ns]; ``NO_EVENT``: none waits."""
    if bus.queued == 0:
        return NO_EVENT
    earliest = NO_EVENT
    for place in range(bus.attached):
        node = bus.nodes[bus.order[place]]
        if node.waiting > 0:
            earliest = min(earliest, ready(bus, node))
    return max(earliest, bus.free)


def winner(bus: Bus, start: int) -> int:
    """Return the slot of the node that wins the bus at ``start`` [ns]."""
    found = NO_SLOT
    lowest = NO_EVENT
    number = 0
    for place in range(bus.attached):
        node = bus.nodes[bus.order[place]]
        if node.waiting > 0 and ready(bus, node) <= start:
            key = bus.requests[node.first].key
            if key < lowest or (key == lowest and node.number < number):
                found = bus.order[place]
                lowest = key
                number = node.number
    return found


# --- a frame begins


def begin(bus: Bus, until: int) -> None:
    """Put the next frame on the free bus if its time has come."""
    start = next_start(bus)
    if start > until:
        return
    attempt = bus.current
    attempt.slot = winner(bus, start)
    sender = bus.nodes[attempt.slot]
    attempt.number = sender.number
    attempt.start = start
    attempt.frame = bus.requests[sender.first].frame
    if attempt.frame.flags & FD != 0 and sender.state == PASSIVE:
        attempt.frame.flags |= ERROR_STATE
    settle(bus, attempt, sender)
    bus.free = attempt.end
    if bus.has_suspended:  # another node has begun a frame
        for place in range(bus.attached):
            bus.nodes[bus.order[place]].suspended = LONG_AGO
        bus.has_suspended = False


def settle(bus: Bus, attempt: Attempt, sender: Node) -> None:
    """Settle what becomes of the frame."""
    attempt.error = NO_ERROR
    attempt.found_by = NOBODY
    attempt.missed_by = NOBODY
    attempt.is_lost = False
    others = bus.acknowledging - (1 if acknowledges(sender) else 0)
    if bus.faulty > 0:
        if sender.has_faults and happens(sender.faults, sender.faults.corruption):
            disturb(bus, attempt, sender, sender, others)
            return
        for place in range(bus.attached):
            reader = bus.nodes[bus.order[place]]
            is_other = reader.has_faults and acknowledges(reader) and reader.number != sender.number
            if is_other and happens(reader.faults, reader.faults.misreading):
                if reader.state == ACTIVE:
                    disturb(bus, attempt, sender, reader, others - 1)
                    return
                attempt.missed_by = reader.number
    if attempt.missed_by != NOBODY:
        others -= 1
    if others > 0:
        attempt.end = attempt.start + frame_duration(attempt.frame, bus.bitrate, bus.data_bitrate)
    else:
        attempt.error = ACK_ERROR
        attempt.found_by = sender.number
        attempt.end = attempt.start + unacknowledged_duration(attempt.frame, bus.bitrate, bus.data_bitrate)


def disturb(bus: Bus, attempt: Attempt, sender: Node, finder: Node, others: int) -> None:
    """Let the frame fail in a bit that all nodes, or one receiver, see inverted."""
    stream = bus.stream
    write_stream(stream, attempt.frame)
    position = stream.first + below(finder.faults, stream.last - stream.first + 1)
    is_alone = finder.number != sender.number
    is_passive = sender.state == PASSIVE
    took = error_duration(stream, position, is_alone, is_passive, others > 0, bus.bitrate, bus.data_bitrate)
    attempt.end = attempt.start + took
    attempt.error = STUFF_ERROR if is_alone else BIT_ERROR
    attempt.found_by = finder.number
    attempt.missed_by = NOBODY


# --- a frame ends


def finish(bus: Bus) -> None:
    """Let the frame on the bus end, well or not."""
    bus.done = bus.current
    bus.current.slot = NO_SLOT
    attempt = bus.done
    sender = bus.nodes[attempt.slot]
    if attempt.error == NO_ERROR:
        succeed(bus, attempt, sender)
    else:
        fail(bus, attempt, sender)
    if bus.off > 0:
        for place in range(bus.attached):
            receive_frame(bus, bus.nodes[bus.order[place]], attempt)
    if sender.state == PASSIVE:
        sender.suspended = attempt.end + bits_duration(SUSPENSION, bus.bitrate)
        bus.has_suspended = True
    if sender.is_leaving:
        forget_if_done(bus, attempt.slot)


def succeed(bus: Bus, attempt: Attempt, sender: Node) -> None:
    """Take the frame out of its queue and reward all who carried it."""
    remove_first(bus, sender)
    if bus.troubled > 0:
        for place in range(bus.attached):
            reward(bus, bus.order[place], attempt)
        count_nodes(bus)
    if sender.has_faults:
        flip(sender.faults, attempt.frame)
        attempt.is_lost = happens(sender.faults, sender.faults.loss)
        babble(bus, sender, attempt.end)
    bus.busy += attempt.end - attempt.start
    add_event(bus, SENT, attempt.end)


def reward(bus: Bus, slot: int, attempt: Attempt) -> None:
    """Count a frame that went well, for a node with counters that are not zero."""
    node = bus.nodes[slot]
    if node.transmit == 0 and node.receive == 0:
        return
    if slot == attempt.slot:
        node.transmit = max(node.transmit - 1, 0)
    elif node.number == attempt.missed_by:
        node.receive = min(node.receive + 1, OFF_LIMIT)
    elif node.state != OFF:
        node.receive = PASSIVE_LIMIT if node.receive > PASSIVE_LIMIT else max(node.receive - 1, 0)
    judge(bus, slot, attempt.end)


def fail(bus: Bus, attempt: Attempt, sender: Node) -> None:
    """Count an error frame."""
    bus.busy += attempt.end - attempt.start
    if attempt.error != ACK_ERROR:
        count_failure(sender)
        for place in range(bus.attached):
            node = bus.nodes[bus.order[place]]
            if node.number != sender.number and acknowledges(node):
                node.receive = min(node.receive + (9 if node.number == attempt.found_by else 1), OFF_LIMIT)
    elif sender.state == ACTIVE:
        count_failure(sender)
    elif sender.state == PASSIVE:
        is_alone = sender.waiting == bus.queued and bus.off == 0
        bus.is_hopeless = is_alone and not is_received(bus, sender)
    add_event(bus, FAILED, attempt.end)
    for place in range(bus.attached):
        judge(bus, bus.order[place], attempt.end)
    count_nodes(bus)


def count_failure(node: Node) -> None:
    """Count an error in a frame of the node's own."""
    node.transmit += 8
    if node.transmit > OFF_LIMIT:
        node.missing = RECOVERY_SEQUENCES


def judge(bus: Bus, slot: int, time: int) -> None:
    """Let the state of a node follow from its counters."""
    node = bus.nodes[slot]
    state = ACTIVE
    if node.transmit > OFF_LIMIT:
        state = OFF
    elif max(node.transmit, node.receive) > PASSIVE_LIMIT:
        state = PASSIVE
    if state == node.state:
        return
    node.state = state
    dropped = 0
    if state == OFF:
        dropped = drop(bus, node)
        node.since = time
    bus.is_hopeless = False
    count_nodes(bus)
    event = add_event(bus, CHANGED, time)
    event.slot = slot
    event.number = node.number
    event.state = state
    event.transmit = node.transmit
    event.receive = node.receive
    event.dropped = dropped


def add_event(bus: Bus, kind: int, time: int) -> Event:
    """Note that something has happened at ``time`` [ns]."""
    event = bus.events[bus.happened]
    bus.happened += 1
    event.kind = kind
    event.time = time
    event.busy = bus.busy
    return event


# --- nodes that are off, or alone


def receive_frame(bus: Bus, node: Node, attempt: Attempt) -> None:
    """Count the silence before a frame, and the 11 recessive bits at the end of any frame."""
    if node.state == OFF and attempt.end > node.since:  # else it is the frame that put it off
        sequence = RECOVERY_BITS_NS // bus.bitrate
        node.missing -= max(attempt.start - node.since, 0) // sequence + 1
        node.since = attempt.end


def recovery(bus: Bus, node: Node) -> int:
    """Return when ``node`` recovers if the bus stays free [ns]."""
    return node.since + max(node.missing, 0) * (RECOVERY_BITS_NS // bus.bitrate)


def recover(bus: Bus, now: int) -> None:
    """Let nodes that are off come back, up to the next frame."""
    until = min(now, next_start(bus))
    while bus.off > 0:
        first = NO_SLOT
        earliest = NO_EVENT
        for place in range(bus.attached):
            node = bus.nodes[bus.order[place]]
            if node.state == OFF and recovery(bus, node) < earliest:
                first = bus.order[place]
                earliest = recovery(bus, node)
        if earliest > until:
            return
        back = bus.nodes[first]
        back.transmit = 0
        back.receive = 0
        back.missing = 0
        judge(bus, first, earliest)
        babble(bus, back, earliest)


def repeat_until(bus: Bus, now: int) -> None:
    """Skip the attempts of a lone error-passive node up to ``now`` [ns]: each is like the one before."""
    if bus.current.slot < 0:
        begin(bus, now)
    attempt = bus.current
    if attempt.slot < 0 or attempt.end > now:
        return
    took = attempt.end - attempt.start
    period = took + bits_duration(SUSPENSION, bus.bitrate)
    skipped = (now - attempt.start) // period
    bus.busy += skipped * took
    attempt.start += skipped * period
    attempt.end += skipped * period
    bus.free = attempt.end


# --- who is there


def acknowledges(node: Node) -> bool:
    return not node.listens_only and not node.is_leaving and node.state != OFF


def is_received(bus: Bus, node: Node) -> bool:
    return bus.acknowledging > (1 if acknowledges(node) else 0)


def count_nodes(bus: Bus) -> None:
    """Count the nodes of each sort."""
    bus.acknowledging = 0
    bus.troubled = 0
    bus.off = 0
    bus.faulty = 0
    for place in range(bus.attached):
        node = bus.nodes[bus.order[place]]
        bus.acknowledging += 1 if acknowledges(node) else 0
        bus.troubled += 1 if node.transmit + node.receive > 0 else 0
        bus.off += 1 if node.state == OFF else 0
        bus.faulty += 1 if node.has_faults else 0


def detach(bus: Bus, slot: int) -> None:
    """Let a node leave; what it has queued is still sent, if a node is there to acknowledge it."""
    node = bus.nodes[slot]
    node.is_leaving = True
    node.has_faults = False
    node.descriptor = -1
    bus.is_hopeless = False
    count_nodes(bus)
    for place in range(bus.attached - 1, -1, -1):
        forget_if_done(bus, bus.order[place])


def forget_if_done(bus: Bus, slot: int) -> None:
    """Forget a node that has left, once its frames have, or can no longer be acknowledged."""
    node = bus.nodes[slot]
    if not node.is_leaving or bus.current.slot == slot or (bus.acknowledging > 0 and node.waiting > 0):
        return
    drop(bus, node)
    node.state = ACTIVE
    place = 0
    while bus.order[place] != slot:
        place += 1
    bus.attached -= 1
    while place < bus.attached:
        bus.order[place] = bus.order[place + 1]
        place += 1
    bus.order[place] = slot
    count_nodes(bus)


# --- faults on purpose, by the dice of a node


def happens(faults: Faults, share: float) -> bool:
    """Return whether something happens that does in a ``share`` of all cases."""
    if share <= 0.0:
        return False
    return uniform(faults) < share


def delay(faults: Faults) -> int:
    """Return how much later than it was sent a frame asks for the bus [ns]."""
    if faults.delay == 0.0 and faults.jitter == 0.0:
        return 0
    late = (faults.delay + faults.jitter * uniform(faults)) * 1e9
    return nearest(late)


def flip(faults: Faults, frame: Frame) -> None:
    """Maybe set one bit of data wrong."""
    length = data_bytes(frame)
    if length > 0 and happens(faults, faults.flips):
        bit = below(faults, 8 * length)
        frame.data[bit // 8] = frame.data[bit // 8] ^ 1 << bit % 8


def babble(bus: Bus, node: Node, time: int) -> None:
    """Let a node that babbles ask for the bus again."""
    if not node.has_faults or node.faults.babble == NOBODY or node.waiting > 0 or node.listens_only:
        return
    frame = bus.asked
    frame.identifier = node.faults.babble
    frame.flags = 0
    frame.code = 8
    for i in range(8):
        frame.data[i] = 0
    append_request(bus, node, time, frame)


def uniform(faults: Faults) -> float:
    """Return a number in [0, 1), as ``random.Random`` does."""
    high = word(faults) >> 5
    low = word(faults) >> 6
    return (float(high) * 67108864.0 + float(low)) / 9007199254740992.0


def below(faults: Faults, limit: int) -> int:
    """Return a whole number in 0 .. ``limit`` - 1, as ``random.Random`` does."""
    bits = 0
    while limit >> bits > 0:
        bits += 1
    found = limit
    while found >= limit:
        found = word(faults) >> 32 - bits
    return found


def word(faults: Faults) -> int:
    """Return 32 random bits: MT19937 [MatsumotoNishimura1998]_."""
    if faults.drawn >= STATE_WORDS:
        for k in range(STATE_WORDS):
            both = faults.words[k] & 2147483648 | faults.words[(k + 1) % STATE_WORDS] & 2147483647
            mixed = faults.words[(k + 397) % STATE_WORDS] ^ both >> 1
            faults.words[k] = mixed ^ 2567483615 if both & 1 == 1 else mixed
        faults.drawn = 0
    y = faults.words[faults.drawn]
    faults.drawn += 1
    y = y ^ y >> 11
    y = y ^ y << 7 & 2636928640
    y = y ^ y << 15 & 4022730752
    return y ^ y >> 18
