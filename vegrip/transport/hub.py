"""The virtual CAN bus itself: a small process of its own that every member is connected to.

Why a process: a thread in the first opener would share its interpreter lock and end with it. Why Unix
sequenced-packet sockets and not a message library: a member that dies, or a hub that dies, is noticed at once
as end of file; a full queue pushes back on its sender; and there is one hop, not three, between two nodes.

The hub is started by whoever opens the channel first and ends by itself when the last one has left. A lock on
a file decides between two that start at once.
"""

import contextlib
import fcntl
import json
import os
import select
import socket
import sys
import time
from collections import deque
from pathlib import Path

from vegrip.clock import NS
from vegrip.transport.arbiter import Arbiter
from vegrip.transport.frame_time import BitTiming
from vegrip.transport.hub_wire import LARGEST, VERSION, numbered, pack_delivery, unpack_request

LONGEST_SLEEP = 0.01  # [s] so that those who come or leave are seen on a slow bus too
LINGER = 1.0  # [s] the hub waits for somebody to come (back)
TRANSMIT_QUEUE = 64  # frames of one member that may wait for the bus; then the member is not read
BACKLOG = 4096  # frames kept for a member that does not read; then they are lost for it, as in any controller


class Member:
    """One node on the bus."""

    def __init__(self, node: int, connection: socket.socket) -> None:
        self.node = node
        self.connection = connection
        self.greeted = False
        self.waiting = 0  # frames it has in the arbiter
        self.hears_itself = False
        self._number = 0
        self._backlog: deque[bytes] = deque()

    @property
    def is_behind(self) -> bool:
        """Whether frames wait for it to read."""
        return bool(self._backlog)

    def hear(self, delivery: bytes) -> None:
        """Bring a frame; the number shows the member what it has missed."""
        self.deliver(numbered(self._number, delivery))
        self._number += 1

    def deliver(self, packet: bytes) -> None:
        """Send ``packet`` now or, when the member does not read, later; beyond ``BACKLOG`` never."""
        delivered = not self._backlog and self._sent(packet)
        if not delivered and len(self._backlog) < BACKLOG:
            self._backlog.append(packet)

    def flush(self) -> None:
        """Send what waits."""
        while self._backlog and self._sent(self._backlog[0]):
            self._backlog.popleft()

    def _sent(self, packet: bytes) -> bool:
        try:
            self.connection.send(packet, socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL)
        except BlockingIOError:
            return False
        except OSError:
            return True  # it has gone; reading from it will show that
        return True


class Hub:
    """Input and output around an :class:`~vegrip.transport.arbiter.Arbiter`."""

    def __init__(self, listener: socket.socket) -> None:
        self._listener = listener
        self._members: dict[int, Member] = {}  # by file descriptor
        self._nodes: dict[int, Member] = {}
        self._arbiter: Arbiter | None = None  # from the first greeting on, which sets the bit rates
        self._busy = 0  # [ns] in all
        self._last_node = 0

    def serve(self) -> None:
        """Carry frames until nobody has been there for ``LINGER``."""
        alone_since = time.monotonic()
        while self._members or time.monotonic() - alone_since < LINGER:
            self._step()
            if self._members:
                alone_since = time.monotonic()

    def _step(self) -> None:
        readers = [fd for fd, member in self._members.items() if member.waiting < TRANSMIT_QUEUE]
        writers = [fd for fd, member in self._members.items() if member.is_behind]
        door = self._listener.fileno()
        readable, writable, _ = select.select([door, *readers], writers, [], self._sleep())
        for fd in writable:
            self._members[fd].flush()
        for fd in readable:
            if fd == door:
                self._admit()
            else:
                self._read(self._members[fd])
        self._advance()

    def _sleep(self) -> float:
        """Sleep while a frame is on the bus; return for how long to wait for requests after it [s].

        Who else wants the bus matters only when it is free again: being woken by each request meanwhile
        would cost more than all the rest.
        """
        event = self._arbiter.next_event() if self._arbiter else None
        if event is None:
            return LINGER / 4
        remaining = (event - time.monotonic_ns()) / NS
        if remaining > 0.0:
            time.sleep(min(remaining, LONGEST_SLEEP))
        return 0.0

    def _advance(self) -> None:
        if self._arbiter is None:
            return
        for sent in self._arbiter.advance(time.monotonic_ns()):
            if sent.node in self._nodes:
                self._nodes[sent.node].waiting -= 1
            self._busy += sent.end - sent.start
            delivery = pack_delivery(sent, self._busy)
            for member in self._nodes.values():
                if member.hears_itself or member.node != sent.node:
                    member.hear(delivery)

    def _admit(self) -> None:
        connection, _ = self._listener.accept()
        self._last_node = (self._last_node + 1) & 0xFFFF
        self._members[connection.fileno()] = Member(self._last_node, connection)

    def _read(self, member: Member) -> None:
        while member.waiting < TRANSMIT_QUEUE:
            try:
                packet = member.connection.recv(LARGEST, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            except OSError:
                packet = b""
            if not packet:
                self._dismiss(member)
                return
            if member.greeted:
                self._request(member, packet)
            else:
                self._greet(member, packet)

    def _request(self, member: Member, packet: bytes) -> None:
        asked = unpack_request(packet)
        if asked is not None and self._arbiter is not None:
            queued, frame = asked
            self._arbiter.request(min(queued, time.monotonic_ns()), member.node, frame)
            member.waiting += 1

    def _greet(self, member: Member, packet: bytes) -> None:
        answer = self._answer(packet)
        if "refused" not in answer:
            answer |= {"node": member.node, "busy": self._busy}
            member.greeted, member.hears_itself = True, bool(answer.pop("own", False))
            self._nodes[member.node] = member
        member.deliver(json.dumps(answer).encode())

    def _answer(self, packet: bytes) -> dict[str, object]:
        try:
            greeting = json.loads(packet)
            version, asked = greeting["version"], BitTiming(**greeting["timing"])
        except (ValueError, TypeError, KeyError):
            return {"refused": "it does not speak the language of this bus"}
        if version != VERSION:
            return {
                "refused": f"its version is {version}, that of the bus {VERSION}; stop the older programs"
            }
        if self._arbiter is None:
            self._arbiter = Arbiter(asked)
        here = self._arbiter.timing
        if greeting.get("strict") and here != asked:
            return {
                "refused": f"the bus runs at {here.bitrate} and {here.data_bitrate} bit/s, "
                f"not at {asked.bitrate} and {asked.data_bitrate}; open it with the same rates"
            }
        rates = {"bitrate": here.bitrate, "data_bitrate": here.data_bitrate}
        return {"timing": rates, "own": greeting.get("own")}

    def _dismiss(self, member: Member) -> None:
        """Let ``member`` go; what it has queued is still sent, as the queue of a network interface is."""
        del self._members[member.connection.fileno()]
        self._nodes.pop(member.node, None)
        member.connection.close()


def main(path: Path) -> None:
    """Serve the bus at ``path`` in a process that outlives the caller, unless somebody serves it already."""
    lock = os.open(path.with_suffix(".lock"), os.O_CREAT | os.O_RDWR, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return
    path.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
        listener.bind(str(path))
        listener.listen(64)
        if os.fork():
            os._exit(0)  # the bus is there: the caller may connect
        _detach()
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)  # for whoever wants to know
        with contextlib.suppress(KeyboardInterrupt):
            Hub(listener).serve()
        path.unlink(missing_ok=True)


def _detach() -> None:
    os.setsid()
    os.chdir("/")
    nothing = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(nothing, standard)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
