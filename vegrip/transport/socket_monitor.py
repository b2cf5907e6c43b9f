"""The events of the connections of one ZeroMQ socket, and a subscription that is made anew when it ends.

libzmq connects again by itself to a publisher that has gone. After an error of the protocol (a message
above MAXMSGSIZE, or bytes that are no message) it does not: it ends the session silently, and the
socket stays deaf for ever. Its events distinguish the two: where it tries again, CONNECT_RETRIED follows
DISCONNECTED at once.
"""

import struct
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Final

import zmq


class Handshakes:
    """Counts refused connections by name.

    ``key_refused``: a publisher does not know our key; ``key_wrong``: a publisher has not the key that we
    expect; ``key_unknown``: we do not know the key of one who wanted to subscribe; ``key_stale``: one who
    wanted to subscribe has not our key. The last two are the trouble of others: ``in_trouble`` is about the
    first two.
    """

    def __init__(self) -> None:
        self.refused: Counter[str] = Counter()
        self._failing: set[str] = set()  # addresses of publishers that cannot be received

    @property
    def in_trouble(self) -> bool:
        """Whether a publisher cannot be received because of keys."""
        return bool(self._failing)

    def published(self, event: int) -> None:
        """Note the outcome of a handshake with a subscriber."""
        if event != zmq.EVENT_HANDSHAKE_SUCCEEDED:
            known = event == zmq.EVENT_HANDSHAKE_FAILED_AUTH
            self.refused["key_unknown" if known else "key_stale"] += 1

    def subscribed(self, address: str, event: int) -> None:
        """Take note of how a handshake with the publisher at ``address`` went."""
        if event == zmq.EVENT_HANDSHAKE_SUCCEEDED:
            self._failing.discard(address)
            return
        known = event == zmq.EVENT_HANDSHAKE_FAILED_AUTH
        self.refused["key_refused" if known else "key_wrong"] += 1
        self._failing.add(address)


MOST_EVENTS: Final = 1024  # taken in one go; a peer that connects without end must not keep the reader
_HEAD: Final = struct.Struct("=Hi")  # event and value


class SocketMonitor:
    """The events of ``watched``; close it before the socket.

    libzmq hands events over in its I/O thread, which waits when they are not read: the queue therefore has no
    bound, and who makes a monitor must read it.
    """

    def __init__(self, watched: zmq.Socket[bytes], events: int) -> None:
        self._watched = watched
        address = f"inproc://monitor-{id(watched):x}"
        watched.monitor(address, events)
        self.socket: zmq.Socket[bytes] = watched.context.socket(zmq.PAIR)
        self.socket.rcvhwm = 0
        self.socket.connect(address)

    def events(self) -> Iterator[tuple[int, bytes]]:
        """Yield event and address of what has happened, at most ``MOST_EVENTS``."""
        for _ in range(MOST_EVENTS):
            if not int(self.socket.getsockopt(zmq.EVENTS)) & zmq.POLLIN:
                return
            head, address = self.socket.recv_multipart(zmq.DONTWAIT)
            yield _HEAD.unpack(head)[0], address

    def stop(self) -> None:
        """Watch no more; what has happened can still be read. From the thread of the watched socket."""
        self._watched.disable_monitor()

    def close(self) -> None:
        self.stop()
        self.socket.close(linger=0)


DONTWAIT = int(zmq.DONTWAIT)
"""As a plain number: flags of the enumeration are looked up in microseconds."""
EVENTS, POLLIN = zmq.EVENTS, int(zmq.POLLIN)
REOPEN_AFTER: Final = 0.1
"""[s] from the end of a connection that libzmq does not try again until it is opened anew: its interval."""

HANDSHAKES: Final = (
    zmq.EVENT_HANDSHAKE_SUCCEEDED
    | zmq.EVENT_HANDSHAKE_FAILED_AUTH
    | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
    | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
)
HANDSHAKE: Final = 3000
"""[ms] in which the other side must greet; libzmq waits ten times as long for what only holds its place."""

_TRIED_AGAIN: Final = (zmq.EVENT_CONNECT_RETRIED, zmq.EVENT_CONNECT_DELAYED, zmq.EVENT_CONNECTED)
_EVENTS: Final = HANDSHAKES | zmq.EVENT_DISCONNECTED | sum(_TRIED_AGAIN)
_KEEPALIVE: Final = (
    (zmq.TCP_KEEPALIVE, 1),
    (zmq.TCP_KEEPALIVE_IDLE, 1),  # [s]
    (zmq.TCP_KEEPALIVE_INTVL, 1),  # [s]
    (zmq.TCP_KEEPALIVE_CNT, 3),
)  # a machine that was switched off sends no end of its connections; who only listens would wait for ever


class Subscription:
    """A subscriber of one address."""

    def __init__(
        self, socket: zmq.Socket[bytes], address: str, on_handshake: Callable[[int], None] | None = None
    ) -> None:
        self.cut_off = 0  # connections that were ended for what came over them
        self._socket = socket
        self._address = address
        self._on_handshake = on_handshake
        self._ended: float | None = None  # [s] when the connection ended that is not tried again so far
        self.descriptor: Final = int(socket.fileno())
        """Signals that something may have come, but only once: wait for it after :meth:`take` gave None."""
        self._monitor = SocketMonitor(socket, int(_EVENTS))
        socket.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE)
        for option, value in _KEEPALIVE if address.startswith("tcp:") else ():
            socket.setsockopt(option, value)
        socket.connect(address)
        socket.subscribe("")

    def take(self) -> Sequence[bytes] | None:
        """Return the parts of the next message, None when there is none.

        Whether one is there is asked before: to look for it and find none is an exception, which costs four
        times as much. The frames know what follows, which costs less than to ask the socket.
        """
        if not int(self._socket.getsockopt(EVENTS)) & POLLIN:
            return None
        try:
            frame = self._socket.recv(DONTWAIT, copy=False)
            parts = [frame.bytes]
            while frame.more:
                frame = self._socket.recv(DONTWAIT, copy=False)
                parts.append(frame.bytes)
        except zmq.Again:
            return None
        return parts

    def look(self, now: float) -> None:
        """See how the connection is at ``now`` [s], and open it anew if libzmq does not."""
        for event, _ in self._monitor.events():
            if event == zmq.EVENT_DISCONNECTED:
                self._ended = now
            elif event in _TRIED_AGAIN:
                self._ended = None
            elif self._on_handshake is not None:
                self._on_handshake(event)
        if self._ended is not None and now - self._ended >= REOPEN_AFTER:
            self._ended = None
            self.cut_off += 1
            self._socket.disconnect(self._address)
            self._socket.connect(self._address)

    def close(self) -> None:
        self._monitor.close()
        self._socket.close(linger=0)
