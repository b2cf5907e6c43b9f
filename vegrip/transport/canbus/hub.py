"""The virtual CAN bus itself: a small process of its own that every member is connected to.

Why a process: a thread in the first opener would share its interpreter lock and end with it. Why Unix
sequenced-packet sockets and not a message library: a member that dies, or a hub that dies, is noticed at once
as end of file; a full queue pushes back on its sender; and there is one hop, not three, between two nodes.

The first program that opens the channel starts the hub, which ends by itself when the last one has left. A
lock on a file decides between two that start at once. :func:`vegrip.transport.canbus.carry.carry` carries the
frames, in Python or in C; here is what happens now and then: a member comes, leaves, wants other filters or
does not read.
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
from itertools import count
from pathlib import Path

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.host import realtime
from vegrip.host.folders import locked
from vegrip.transport.canbus import carry
from vegrip.transport.canbus.bus_model import BusModel
from vegrip.transport.canbus.bus_records import PACKET_BYTES, TRANSMIT_QUEUE
from vegrip.transport.canbus.compiled_bus import Search
from vegrip.transport.canbus.hub_wire import Greeting, read_greeting, unpack_filters

LINGER = 1.0  # [s] the hub waits for a member to come (back)
AT_ONCE = int(
    socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL
)  # a number: to join the flags takes as long as to send
NODES = 0xFFFF  # numbers of nodes have 16 bits
MOST_MEMBERS = 256  # far below what select() can watch and a process may open
MOST_NEWCOMERS = 64  # besides; they are accepted, and answered so when there is no room
GREETING_WITHIN = 2.0  # [s] from the connection on; who says nothing must not keep a place
CARRIED_AT_ONCE = NS // 10  # [ns] for which frames are carried at a time: C handles no signals
FOLDERS = ("VEGRIP_CACHE", "VEGRIP_RUNTIME_DIR", "XDG_CACHE_HOME", "XDG_RUNTIME_DIR")
"""Environment variables that name folders, maybe from where the first member was started."""
MEMBER_BACKLOG_FRAMES = (
    4096  # frames kept for a member that does not read; then they are lost for it, as in any controller
)


class Member:
    """One connection: a newcomer, and from its greeting on a node on the bus."""

    def __init__(self, number: int, connection: socket.socket) -> None:
        connection.setblocking(False)
        self.number = number  # as a node
        self.connection = connection
        self.is_greeted = False
        self.since = time.monotonic()  # [s]
        self._backlog: deque[bytes] = deque()

    @property
    def is_behind(self) -> bool:
        return bool(self._backlog)

    def deliver(self, packet: bytes) -> None:
        """Send ``packet`` now, or later when the member does not read: ``MEMBER_BACKLOG_FRAMES`` at most."""
        if (self._backlog or not self._sent(packet)) and len(self._backlog) < MEMBER_BACKLOG_FRAMES:
            self._backlog.append(packet)

    def flush(self) -> None:
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
    """Who is on the bus, around the loop that carries frames."""

    def __init__(self, listener: socket.socket, search: Search | None = None) -> None:
        self._listener = listener
        self._search = search  # for the compiled loop; None: Python carries all frames
        self._door = select.epoll()  # newcomers, the listener, and members that are behind
        self._is_open = False
        self._members: dict[int, Member] = {}  # by file descriptor
        self._nodes: dict[int, Member] = {}
        self._bus: BusModel | None = None  # from the first greeting on, which sets the bit rates
        self._last_node = 0
        self._open_door()

    def serve(self) -> None:
        """Carry frames until no member has been there for ``LINGER``."""
        alone_since = time.monotonic()
        while self._members or time.monotonic() - alone_since < LINGER:
            if self._members:
                alone_since = time.monotonic()
            self._step()

    def _step(self) -> None:
        bus, why = self._bus, carry.NEWCOMER
        patience = LINGER / 4
        if bus is not None:
            patience = 0.0
            why = self._carry(bus)
            self._take_outbox(bus)
        if why == carry.NEWCOMER:
            for fd, events in self._door.poll(patience):
                self._hear(fd, events)
        elif bus is not None and why in (carry.OTHER_PACKET, carry.GONE):
            member = self._nodes[bus.record.nodes[bus.record.who].number]
            packet = bytes(bus.record.packet[: bus.record.length])
            if not packet:  # it has gone
                self._dismiss(member)
            elif (pairs := unpack_filters(packet)) is not None:
                bus.accept(member.number, pairs)
        self._dismiss_the_dead()
        self._dismiss_the_silent()
        self._open_door()

    def _carry(self, bus: BusModel) -> int:
        now = time.monotonic_ns()
        compiled = self._search.found(now) if self._search is not None else None
        if compiled is not None:
            bus.use(compiled)
        bus.record.door = self._door.fileno()
        return bus.carry(now + CARRIED_AT_ONCE)

    def _take_outbox(self, bus: BusModel) -> None:
        record = bus.record
        for unsent in record.packets[: record.unsent]:
            node = record.nodes[unsent.slot].number
            self._keep(self._nodes[node], bytes(record.outbox[unsent.at : unsent.at + unsent.size]))
        record.unsent = record.outbox_bytes = 0

    def _keep(self, member: Member, packet: bytes) -> None:
        member.deliver(packet)
        self._watch(member)

    def _watch(self, member: Member) -> None:
        assert self._bus is not None  # noqa: S101 (there are no nodes without)
        node, fd = self._bus.node(member.number), member.connection.fileno()
        node.is_behind = member.is_behind
        with contextlib.suppress(FileExistsError, FileNotFoundError):
            if member.is_behind:
                self._door.register(fd, select.EPOLLOUT)
            else:
                self._door.unregister(fd)

    def _open_door(self) -> None:
        is_open = len(self._members) < MOST_MEMBERS + MOST_NEWCOMERS
        if is_open and not self._is_open:
            self._door.register(self._listener.fileno(), select.EPOLLIN)
        if self._is_open and not is_open:
            self._door.unregister(self._listener.fileno())
        self._is_open = is_open

    def _hear(self, fd: int, events: int) -> None:
        if fd == self._listener.fileno():
            self._admit()
        elif (member := self._members.get(fd)) is None:
            return
        elif not member.is_greeted:
            self._read_greeting(member)
        elif events & (select.EPOLLHUP | select.EPOLLERR):
            self._dismiss(member)
        else:
            member.flush()
            self._watch(member)

    def _dismiss_the_dead(self) -> None:
        """Remove members that have left with a full queue.

        They are not read, so that their leaving would never be seen.
        """
        bus = self._bus
        if bus is None or bus.queued < TRANSMIT_QUEUE:  # no queue can be full
            return
        for node, member in list(self._nodes.items()):
            is_full = bus.waiting(node) >= TRANSMIT_QUEUE
            if is_full and not bus.is_received(node) and _has_left(member.connection):
                self._dismiss(member)

    def _dismiss_the_silent(self) -> None:
        if len(self._members) == len(self._nodes):
            return
        latest = time.monotonic() - GREETING_WITHIN
        for member in [m for m in self._members.values() if not m.is_greeted and m.since < latest]:
            self._dismiss(member)

    def _admit(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError:  # it has gone again, or there is no descriptor for it
            return
        taken = {member.number for member in self._members.values()}
        self._last_node = next(node for n in count(1) if (node := self._last_node + n & NODES) not in taken)
        self._members[connection.fileno()] = Member(self._last_node, connection)
        self._door.register(connection.fileno(), select.EPOLLIN)

    def _read_greeting(self, member: Member) -> None:
        try:
            packet = member.connection.recv(PACKET_BYTES, AT_ONCE)
        except BlockingIOError:
            return
        except OSError:
            packet = b""
        if packet:
            self._greet(member, packet)
        else:
            self._dismiss(member)

    def _greet(self, member: Member, packet: bytes) -> None:
        try:
            greeting = read_greeting(packet)
            bus = self._joined(greeting)
            bus.catch_up()  # who joins now takes part from now on
            self._take_outbox(bus)
            now = time.monotonic_ns()
            bus.attach(member.number, listen_only=greeting.listen_only, faults=greeting.faults, time=now)
        except ConfigError as error:
            member.deliver(json.dumps({"refused": str(error)}).encode())
            return
        self._door.unregister(member.connection.fileno())
        member.is_greeted = True
        self._nodes[member.number] = member
        node = bus.node(member.number)
        node.descriptor, node.hears_itself = member.connection.fileno(), greeting.wants_own_frames
        if greeting.patience >= 0.0:
            node.patience = round(greeting.patience * NS)
        here = {"bitrate": bus.timing.bitrate, "data_bitrate": bus.timing.data_bitrate}
        answer = {"timing": here, "node": member.number, "busy": bus.busy}
        self._keep(member, json.dumps(answer).encode())

    def _joined(self, greeting: Greeting) -> BusModel:
        """Return the bus, made when it is the first greeting; ConfigError: it is full, or has other rates."""
        if len(self._nodes) >= MOST_MEMBERS:
            raise ConfigError(f"it has {MOST_MEMBERS} members, and no room for more")
        asked = greeting.timing
        if self._bus is None:
            self._bus = BusModel(asked, carry)
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
        if member.is_greeted and self._bus is not None:
            del self._nodes[member.number]
            self._bus.detach(member.number)
        with contextlib.suppress(FileNotFoundError):
            self._door.unregister(member.connection.fileno())
        member.connection.close()


def _has_left(connection: socket.socket) -> bool:
    poll = select.poll()
    poll.register(connection, 0)
    return bool(poll.poll(0))  # only a hang-up or an error is reported


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
        for name in FOLDERS:
            if given := os.environ.get(name):
                os.environ[name] = str(Path(given).absolute())
        os.setsid()
        os.chdir("/")
        nothing = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):
            os.dup2(nothing, standard)
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)  # for people who look for it
        gc.freeze()
        realtime.priority_of(realtime.HUB_PRIORITY).take()  # without: the nodes say what is not permitted
        with contextlib.suppress(KeyboardInterrupt):
            Hub(listener, Search()).serve()
        path.unlink(missing_ok=True)
        path.with_suffix(".lock").unlink(missing_ok=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
