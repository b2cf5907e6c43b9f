"""How many may be connected to a listening ZeroMQ socket at a time.

libzmq has no such limit, and aborts the process when accept() finds no free descriptor on an ipc socket. So a
thread follows its events. When too many are connected, or descriptors get scarce, it renames the socket's
file: connected ones stay, and others find nothing to connect to, try again by themselves, as libzmq does, and
come in when there is room.

Between a connection and the event of it more may come, since accepting needs no interpreter lock and this
thread waits for its turn: 30 to 140 came in so on two busy cores, and once more than 700 where the thread did
not run for some 30 ms. So a process that may open few files keeps three quarters of them free.
With the 65 536 that a node takes where the system lets it, no such delay uses them up.
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
from vegrip.host.folders import ASIDE
from vegrip.transport.socket_monitor import HANDSHAKE, SocketMonitor

MAX_CONNECTIONS: Final = 256
"""Connections to one socket; a sixteenth of the descriptors where that is less."""

SPARE: Final = 1024
"""Descriptors that stay free; three quarters of all where that is less."""

ACCEPT_BACKLOG: Final = 4  # connections that the kernel keeps until they are accepted
LOOK_PERIOD_S: Final = 0.2  # [s] between two looks without an event

_EVENTS: Final = zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED | zmq.EVENT_MONITOR_STOPPED


class ConnectionLimit:
    """Keeps the connections of ``socket`` within ``MAX_CONNECTIONS``.

    Make it before the socket is bound, :meth:`start` it afterwards, and close it before the socket. A socket
    of another kind than ipc is followed, but not limited: there libzmq survives a lack of descriptors.
    """

    def __init__(
        self,
        socket: zmq.Socket[bytes],  # only one may watch it
        address: str,  # where it will listen, "" for one that does not
        counts: Counter[str],  # gets ``connections``, the times that no more were let in
        events: int = 0,  # further ones that are wanted
        on_event: Callable[[int], None] | None = None,  # called for these, in the thread of the limit
    ) -> None:
        self._file = Path(address.removeprefix("ipc://")) if address.startswith("ipc://") else None
        if self._file is not None:
            socket.setsockopt(zmq.BACKLOG, ACCEPT_BACKLOG)
            self._aside(self._file).unlink(missing_ok=True)
        socket.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE)
        self._counts = counts
        self._on_event = on_event
        self._monitor = SocketMonitor(socket, int(_EVENTS) | events)
        self._inside = 0
        self._is_shut = False
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="connections", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def connected(self) -> int:
        with self._lock:
            for event, _ in self._monitor.events():
                if event == zmq.EVENT_ACCEPTED:
                    self._inside += 1
                    self._judge()
                elif event == zmq.EVENT_DISCONNECTED:
                    self._inside -= 1
                elif self._on_event is not None and event != zmq.EVENT_MONITOR_STOPPED:
                    self._on_event(event)
            self._judge()
            return self._inside

    def close(self) -> None:
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
            select.select([descriptor], [], [], LOOK_PERIOD_S)

    def _judge(self) -> None:
        if self._file is None:
            return
        limit = descriptors.limit()
        is_scarce = descriptors.free() < min(SPARE, limit * 3 // 4)  # whatever they are used for
        is_full = self._inside >= min(MAX_CONNECTIONS, limit // 16)
        if self._is_shut and not is_scarce and not is_full:
            self._open()
        elif not self._is_shut and (is_scarce or is_full):
            self._is_shut = True
            self._counts["connections"] += 1
            with contextlib.suppress(OSError):
                self._file.rename(self._aside(self._file))

    def _open(self) -> None:
        if self._is_shut and self._file is not None:
            with contextlib.suppress(OSError):
                self._aside(self._file).rename(self._file)
        self._is_shut = False

    @staticmethod
    def _aside(file: Path) -> Path:
        return file.with_name(f"{file.name}{ASIDE}")
