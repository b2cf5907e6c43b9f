"""How many may be connected to a listening ZeroMQ socket at a time.

libzmq has no such limit, and aborts the process when accept() finds no free descriptor on an ipc socket. So a
thread follows its events. When too many are connected, or descriptors get scarce, it renames the socket's
file: connected ones stay, and others find nothing to connect to, try again by themselves, as libzmq does, and
come in when there is room.

Between a connection and the event of it more may come, since accepting needs no interpreter lock. With four
programs that connect without end on two cores 60 to 70 came in so, and 110 beside a thread that never waits;
``SPARE`` leaves room for that.
"""

import contextlib
import select
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Final

import zmq

from vegrip.host import descriptors
from vegrip.host.runtime_folder import ASIDE
from vegrip.transport.socket_monitor import SocketMonitor

MOST: Final = 256
"""Connections to one socket."""

SPARE: Final = 256
"""Descriptors that stay free; a quarter of all where that is less."""

BACKLOG: Final = 4  # connections that the kernel keeps until they are accepted
HANDSHAKE: Final = 3000  # [ms] in which one that connects must greet; who says nothing must not keep a place
LOOK: Final = 0.2  # [s] between two looks without an event

_EVENTS: Final = zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED | zmq.EVENT_MONITOR_STOPPED


class ConnectionLimit:
    """Keeps the connections of ``socket`` within ``MOST``.

    Make it before the socket is bound, :meth:`start` it afterwards, and close it before the socket. A socket
    of another kind than ipc is followed, but not limited: there libzmq survives a lack of descriptors.

    Args:
        socket: to be watched; only one may watch it.
        address: where it will listen, "" for one that does not.
        counts: where ``connections`` is counted, the times that no more were let in.
        events: further ones that are wanted.
        on_event: told of these, in the thread of the limit.

    """

    def __init__(
        self,
        socket: zmq.Socket[bytes],
        address: str,
        counts: Counter[str],
        events: int = 0,
        on_event: Callable[[int], None] | None = None,
    ) -> None:
        self._file = Path(address.removeprefix("ipc://")) if address.startswith("ipc://") else None
        if self._file is not None:
            socket.setsockopt(zmq.BACKLOG, BACKLOG)
            self._aside(self._file).unlink(missing_ok=True)
        socket.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE)
        self._counts = counts
        self._on_event = on_event
        self._monitor = SocketMonitor(socket, int(_EVENTS) | events)
        self._inside = 0
        self._shut = False
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="connections", daemon=True)

    def start(self) -> None:
        """Watch the socket, which listens now."""
        self._thread.start()

    def connected(self) -> int:
        """Return how many are connected now."""
        with self._lock:
            for event, _ in self._monitor.events():
                self._note(event)
            self._judge()
            return self._inside

    def close(self) -> None:
        """Watch no more."""
        self._stop.set()
        self._monitor.stop()  # the event of which wakes the thread
        if self._thread.is_alive():
            self._thread.join()
        self._open()
        self._monitor.close()

    def _run(self) -> None:
        descriptor = int(self._monitor.socket.fileno())
        while not self._stop.is_set():
            self.connected()
            select.select([descriptor], [], [], LOOK)

    def _note(self, event: int) -> None:
        if event == zmq.EVENT_ACCEPTED:
            self._inside += 1
            self._judge()
        elif event == zmq.EVENT_DISCONNECTED:
            self._inside -= 1
        elif self._on_event is not None and event != zmq.EVENT_MONITOR_STOPPED:
            self._on_event(event)

    def _judge(self) -> None:
        if self._file is None:
            return
        scarce = descriptors.free() < min(SPARE, descriptors.limit() // 4)  # whatever they are used for
        if self._shut and not scarce and self._inside < MOST:
            self._open()
        elif not self._shut and (scarce or self._inside >= MOST):
            self._shut = True
            self._counts["connections"] += 1
            with contextlib.suppress(OSError):
                self._file.rename(self._aside(self._file))

    def _open(self) -> None:
        if self._shut and self._file is not None:
            with contextlib.suppress(OSError):
                self._aside(self._file).rename(self._file)
        self._shut = False

    @staticmethod
    def _aside(file: Path) -> Path:
        return file.with_name(f"{file.name}{ASIDE}")
