"""The virtual CAN bus itself: a small process of its own that every member is connected to.

Why a process: a thread in the first opener would share its interpreter lock and end with it. Why Unix
sequenced-packet sockets and not a message library: a member that dies, or a hub that dies, is noticed at once
as end of file; a full queue pushes back on its sender; and there is one hop, not three, between two nodes.

The first program that opens the channel starts the hub, which ends by itself when the last one has left. A
lock on a file decides between two that start at once.
"""

import contextlib
import gc
import json
import os
import select
import socket
import sys
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.host import realtime
from vegrip.host.folders import locked
from vegrip.transport.canbus.acceptance import MAX_FILTERS_BYTES, Acceptance, unpack_filters
from vegrip.transport.canbus.bus_events import BusError, Event, StateChange, Transmission
from vegrip.transport.canbus.bus_model import BusModel
from vegrip.transport.canbus.compiled_bus import Search
from vegrip.transport.canbus.error_free_bus import ErrorFreeBus
from vegrip.transport.canbus.error_report import error_report, state_report
from vegrip.transport.canbus.greeting import Greeting, read_greeting
from vegrip.transport.canbus.hub_wire import (
    MAX_GATHERED_BYTES,
    numbered,
    pack_delivery,
    pack_error,
    split_requests,
    unpack_request,
)
from vegrip.transport.canbus.kernels.limits import (
    GATHERED,
    LONGEST_SLEEP,
    NO_EVENT,
    OLDEST_REQUEST,
    SLICE,
    TRANSMIT_QUEUE,
)
from vegrip.transport.canbus.kernels.memory import MOST_SLOTS
from vegrip.transport.canbus.leaving import Why

LONGEST_PACKET = max(MAX_FILTERS_BYTES, MAX_GATHERED_BYTES)  # bytes
LINGER = 1.0  # [s] the hub waits for a member to come (back)
AT_ONCE = int(
    socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL
)  # a number: to join the flags takes as long as to send
MOST_MEMBERS = 256  # far below what select() can watch and a process may open
MOST_NEWCOMERS = 64  # besides; they are heard, and told so when there is no room
GREETING_WITHIN = 2.0  # [s] from the connection on; who says nothing must not keep a place
COMPILED_SLICE = NS // 10  # [ns] for which the compiled loop runs at a time: it hears no signals
FOLDERS = ("VEGRIP_CACHE", "VEGRIP_RUNTIME_DIR", "XDG_CACHE_HOME", "XDG_RUNTIME_DIR")
"""Environment variables that name folders, maybe from where the first member was started."""
MEMBER_BACKLOG_FRAMES = (
    4096  # frames kept for a member that does not read; then they are lost for it, as in any controller
)


class Member:
    """One node on the bus."""

    def __init__(self, node: int, connection: socket.socket) -> None:
        self.node = node
        self.connection = connection
        self.greeted = False
        self.since = time.monotonic()  # [s]
        self.hears_itself = False
        self.patience: int | None = None  # [ns] for which deliveries may wait for others; None: none does
        self.acceptance = Acceptance()
        self.number = 0  # of its next delivery
        self.gathered = bytearray()
        self._backlog: deque[bytes] = deque()
        self.due = NO_EVENT  # [ns] when what is gathered is to be handed out

    def fileno(self) -> int:
        """Return the descriptor of its connection."""
        return self.connection.fileno()

    @property
    def is_behind(self) -> bool:
        """Whether frames wait for it to read."""
        return bool(self._backlog)

    def hear(self, delivery: bytes) -> None:
        """Bring a frame; the number shows the member what it has missed."""
        packet = numbered(self.number, delivery)
        self.number += 1
        if self.patience is None:
            self.deliver(packet)
            return
        if len(self.gathered) + len(packet) > MAX_GATHERED_BYTES:
            self.hand_out()
        if not self.gathered:
            self.due = time.monotonic_ns() + self.patience
        self.gathered += packet

    def hand_out(self) -> None:
        """Bring what is gathered."""
        self.deliver(bytes(self.gathered))
        self.gathered.clear()
        self.due = NO_EVENT

    def deliver(self, packet: bytes) -> None:
        """Send ``packet`` now, or later when the member does not read: ``MEMBER_BACKLOG_FRAMES`` at most."""
        if (self._backlog or not self._sent(packet)) and len(self._backlog) < MEMBER_BACKLOG_FRAMES:
            self._backlog.append(packet)

    def flush(self) -> None:
        """Send what waits."""
        while self._backlog and self._sent(self._backlog[0]):
            self._backlog.popleft()

    def _sent(self, packet: bytes) -> bool:
        try:
            self.connection.send(packet, AT_ONCE)
        except BlockingIOError:
            return False
        except OSError:
            return True  # it has gone; reading from it will show that
        return True


class Hub:
    """Input and output around a :class:`~vegrip.transport.canbus.bus_model.BusModel`."""

    def __init__(self, listener: socket.socket, search: Search | None = None) -> None:
        self._listener = listener
        self._search = search  # for the compiled loop; None: Python carries all frames
        self._memory: ErrorFreeBus | None = None  # of the compiled loop, once there is one
        self._members: dict[int, Member] = {}  # by file descriptor
        self._nodes: dict[int, Member] = {}
        self._gathering: dict[int, Member] = {}  # by node, those that take several frames at once
        self._due = NO_EVENT  # [ns] when one of them is to be handed what was gathered
        self._bus: BusModel | None = None  # from the first greeting on, which sets the bit rates
        self._last_node = 0

    def serve(self) -> None:
        """Carry frames until no member has been there for ``LINGER``."""
        alone_since = time.monotonic()
        while self._members or time.monotonic() - alone_since < LINGER:
            self._carry_compiled()
            if self._members:
                alone_since = time.monotonic()
            self._step()

    def _carry_compiled(self) -> None:
        """Let the compiled loop carry frames until something is out of the ordinary; deal with that."""
        bus, search = self._bus, self._search
        compiled = search.found(time.monotonic_ns()) if search is not None else None
        if bus is None or compiled is None or not len(self._members) == len(self._nodes) <= MOST_SLOTS:
            return
        members = list(self._nodes.values())
        memory = self._memory = self._memory or ErrorFreeBus()
        if any(m.is_behind for m in members) or not memory.load(bus, members, self._listener.fileno()):
            return
        why = Why.TIME
        while why == Why.TIME:  # a signal that has come is dealt with in between
            why = compiled.loop(*memory.addresses, time.monotonic_ns() + COMPILED_SLICE)
        for node, packet in memory.unsent():
            self._nodes[node].deliver(packet)
        self._due = memory.store(bus)
        if why == Why.NEWCOMER:
            self._admit()
        elif why in (Why.OTHER_PACKET, Why.GONE):
            node, packet = memory.received()
            self._take(self._nodes[node], packet)

    def _step(self) -> None:
        patience = self._sleep()
        if self._bus is not None:
            self._tell(self._bus, self._bus.conclude(time.monotonic_ns()))
            self._hand_out()
        readers = list(self._members)
        if self._bus is not None and self._bus.queued >= TRANSMIT_QUEUE:  # else no queue can be full
            self._dismiss_the_dead()
            readers = [fd for fd, member in self._members.items() if self._has_room(member)]
        writers = [fd for fd, member in self._members.items() if member.is_behind]
        door = self._listener.fileno()
        if len(self._members) < MOST_MEMBERS + MOST_NEWCOMERS:  # else the next one waits
            readers.append(door)
        readable, writable, _ = select.select(readers, writers, [], patience)
        for fd in writable:
            self._members[fd].flush()
        for fd in readable:
            if fd == door:
                self._admit()
            else:
                self._read(self._members[fd])
        self._dismiss_the_silent()
        self._advance()
        self._hand_out()

    def _hand_out(self) -> None:
        """Bring what was gathered for long enough."""
        now = time.monotonic_ns()
        if self._due > now:
            return
        for member in self._gathering.values():
            if member.due <= now:
                member.hand_out()
        self._due = min((member.due for member in self._gathering.values()), default=NO_EVENT)

    def _sleep(self) -> float:
        """Sleep while a frame is on the bus; return for how long to wait for requests after it [s].

        Who else wants the bus matters only when it is free again: being woken by each request meanwhile
        would cost more than all the rest. While frames wait behind the one on the bus, those that end within
        ``GATHERED`` are handed out at once: a wake-up, here and at each member, costs more than a frame. What
        the bus does when, and the times of the frames, do not change by that.
        """
        event = self._bus.next_event() if self._bus else None
        if event is None or self._bus is None:
            return min(max((self._due - time.monotonic_ns()) / NS, 0.0), LINGER / 4)
        if self._bus.queued > 1 and self._bus.is_healthy:
            event += GATHERED
        remaining = (event - time.monotonic_ns()) / NS
        if remaining > 0.0:
            time.sleep(min(remaining, LONGEST_SLEEP / NS))
        return 0.0

    def _advance(self) -> None:
        """Bring the bus up to the present, or by a slice towards it when that is far."""
        if self._bus is None:
            return
        now, event = time.monotonic_ns(), self._bus.next_event()
        self._tell(self._bus, self._bus.advance(now if event is None else min(now, event + SLICE)))

    def _tell(self, bus: BusModel, events: Sequence[Event]) -> None:
        busy = bus.busy - sum(one.end - one.start for one in events if not isinstance(one, StateChange))
        for event in events:
            if isinstance(event, StateChange):
                self._tell_state(event, busy)
                continue
            busy += event.end - event.start
            if isinstance(event, Transmission):
                self._deliver(event, busy)
            else:
                self._tell_error(event, busy)

    def _deliver(self, sent: Transmission, busy: int) -> None:
        if sent.is_lost:
            return
        delivery, frame = pack_delivery(sent, busy), sent.frame
        deaf = sent.node, sent.missed_by
        for node, member in self._nodes.items():
            if (node not in deaf or member.hears_itself) and member.acceptance.accepts(
                frame.identifier, extended=frame.extended
            ):
                self._bring(member, delivery)

    def _bring(self, member: Member, delivery: bytes) -> None:
        member.hear(delivery)
        self._due = min(self._due, member.due)

    def _tell_error(self, error: BusError, busy: int) -> None:
        for node, member in self._nodes.items():
            self._bring(member, pack_error(error.end, busy, node, error_report(error, node)))

    def _tell_state(self, change: StateChange, busy: int) -> None:
        if (member := self._nodes.get(change.node)) is not None:
            self._bring(member, pack_error(change.time, busy, change.node, state_report(change)))

    def _dismiss_the_dead(self) -> None:
        """Remove members that have left with a full queue.

        They are not read, so that their leaving would never be seen.
        """
        for member in [member for member in self._members.values() if not self._has_room(member)]:
            if self._bus is not None and not self._bus.is_heard(member.node) and _has_left(member.connection):
                self._dismiss(member)

    def _has_room(self, member: Member) -> bool:
        return self._bus is None or self._bus.waiting(member.node) < TRANSMIT_QUEUE

    def _dismiss_the_silent(self) -> None:
        if len(self._members) == len(self._nodes):
            return
        latest = time.monotonic() - GREETING_WITHIN
        for member in [m for m in self._members.values() if not m.greeted and m.since < latest]:
            self._dismiss(member)

    def _admit(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError:  # it has gone again, or there is no descriptor for it
            return
        self._last_node = (self._last_node + 1) & 0xFFFF
        self._members[connection.fileno()] = Member(self._last_node, connection)

    def _read(self, member: Member) -> None:
        while self._has_room(member):
            try:
                packet = member.connection.recv(LONGEST_PACKET, AT_ONCE)
            except BlockingIOError:
                return
            except OSError:
                packet = b""
            self._take(member, packet)
            if not packet:
                return

    def _take(self, member: Member, packet: bytes) -> None:
        """Deal with what a member has sent; nothing: it has gone."""
        if not packet:
            self._dismiss(member)
        elif member.greeted:
            self._request(member, packet)
        else:
            self._greet(member, packet)

    def _request(self, member: Member, packet: bytes) -> None:
        asked = unpack_request(packet)
        if asked is None and (pairs := unpack_filters(packet)) is not None:
            member.acceptance = Acceptance(pairs)
            return
        if self._bus is None:
            return
        now = time.monotonic_ns()
        for queued, frame in split_requests(packet) if asked is None else (asked,):
            self._bus.request(min(max(queued, now - OLDEST_REQUEST), now), member.node, frame)

    def _greet(self, member: Member, packet: bytes) -> None:
        try:
            greeting = read_greeting(packet)
            bus = self._joined(greeting)
        except ConfigError as error:
            member.deliver(_refusal(str(error)))
            return
        self._advance()  # who joins now takes part from now on
        here = bus.timing
        answer = {
            "timing": {"bitrate": here.bitrate, "data_bitrate": here.data_bitrate},
            "node": member.node,
            "busy": bus.busy,
        }
        member.greeted, member.hears_itself = True, greeting.wants_own_frames
        if greeting.patience >= 0.0:
            member.patience = round(greeting.patience * NS)
            self._gathering[member.node] = member
        bus.attach(
            member.node,
            listen_only=greeting.listen_only,
            faults=greeting.faults,
            time=time.monotonic_ns(),
        )
        self._nodes[member.node] = member
        member.deliver(json.dumps(answer).encode())

    def _joined(self, greeting: Greeting) -> BusModel:
        """Return the bus, made when it is the first greeting; ConfigError: it is full, or has other rates."""
        if len(self._nodes) >= MOST_MEMBERS:
            raise ConfigError(f"it has {MOST_MEMBERS} members, and no room for more")
        asked = greeting.timing.timing
        if self._bus is None:
            self._bus = BusModel(asked)
        here = self._bus.timing
        if greeting.must_match_rates and here != asked:
            raise ConfigError(
                f"the bus runs at {here.bitrate} and {here.data_bitrate} bit/s, "
                f"not at {asked.bitrate} and {asked.data_bitrate}; open it with the same rates"
            )
        return self._bus

    def _dismiss(self, member: Member) -> None:
        """Let ``member`` go; what it has queued is still sent, as the queue of a network interface is."""
        del self._members[member.connection.fileno()]
        self._gathering.pop(member.node, None)
        if self._nodes.pop(member.node, None) is not None and self._bus is not None:
            self._bus.detach(member.node)
        member.connection.close()


def _refusal(reason: str) -> bytes:
    return json.dumps({"refused": reason}).encode()


def _has_left(connection: socket.socket) -> bool:
    poll = select.poll()
    poll.register(connection, 0)
    return bool(poll.poll(0))  # only a hang-up or an error is told


def main(path: Path) -> None:
    """Serve the bus at ``path`` in a process that outlives the caller, unless one serves it already."""
    lock = locked(path.with_suffix(".lock"))
    if lock is None:
        return
    path.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
        listener.bind(str(path))
        listener.listen(64)
        if os.fork():
            os._exit(0)  # the bus is there: the caller may connect
        _detach()
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)  # for people who look for it
        gc.freeze()
        realtime.priority_of(realtime.HUB_PRIORITY).take()  # without: the nodes say what is not permitted
        with contextlib.suppress(KeyboardInterrupt):
            Hub(listener, Search()).serve()
        path.unlink(missing_ok=True)
        path.with_suffix(".lock").unlink(missing_ok=True)


def _detach() -> None:
    for name in FOLDERS:
        if given := os.environ.get(name):
            os.environ[name] = str(Path(given).absolute())
    os.setsid()
    os.chdir("/")
    nothing = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(nothing, standard)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
