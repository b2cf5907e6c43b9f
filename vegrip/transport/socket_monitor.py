"""The events of the connections of one ZeroMQ socket."""

import struct
from collections.abc import Iterator
from typing import Final

import zmq

MOST_EVENTS: Final = 1024  # taken in one go; a peer that connects without end must not keep the reader
_HEAD: Final = struct.Struct("=Hi")  # event and value


class SocketMonitor:
    """The events of ``watched``; close it before the socket.

    libzmq hands events over in its I/O thread, which waits when they are not read: the queue therefore has no
    bound, and who makes a monitor must read it.

    Args:
        watched: a socket of any kind.
        events: those that are wanted, ``zmq.EVENT_...`` joined with ``|``.

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
        """Watch no more, and forget what has happened."""
        self.stop()
        self.socket.close(linger=0)
