"""The thread that hears the nodes and turns what it hears into the events of the page, 25 a second."""

import threading
import time
from collections.abc import Callable
from contextlib import closing

from vegrip.errors import VegripError
from vegrip.messages import (
    ContactEstimate,
    FingertipState,
    ForceCommand,
    LearnedParameter,
    ModelHealth,
    SlipMargin,
)
from vegrip.runtime.client import ask
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.watch import Watch
from vegrip.runtime.registry import running_nodes
from vegrip.web.live.columns import COLUMN_PERIOD_S
from vegrip.web.live.event_log import EventLog
from vegrip.web.live.page import routes
from vegrip.web.live.view import LiveView
from vegrip.web.server import serve

EVERY_ONE = (SlipMargin, LearnedParameter)
NEWEST_ONLY = (ContactEstimate, ForceCommand, FingertipState, ModelHealth)
"""One of these in 40 ms is as much as a screen shows; each that is sent costs the node time."""
ASK_PERIOD = 2.0  # [s] between two questions for the wanted margins
ASK_PATIENCE = 0.5  # [s]


class Stream:
    """Hears all nodes of this machine in a thread of its own; pages read its ``log``."""

    def __init__(self) -> None:
        self._watch = Watch(EVERY_ONE, NEWEST_ONLY, waits=True)
        self.log = EventLog(LiveView(Board(time.monotonic_ns())))
        self._wishes = WantedMargins()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="watch", daemon=True)

    def start(self) -> None:
        self._thread.start()
        self._wishes.start()

    def close(self) -> None:
        """End both threads."""
        self._stop.set()
        self._wishes.close()
        self._thread.join()
        self._watch.close()

    def _run(self) -> None:
        due = time.monotonic() + COLUMN_PERIOD_S
        while not self._stop.is_set():
            self._watch.step(self.log.view)
            if (now := time.monotonic()) >= due:
                self.log.tick(time.monotonic_ns(), self._wishes)
                due = max(due + COLUMN_PERIOD_S, now)
            self._stop.wait(max(0.0, min(due - time.monotonic(), COLUMN_PERIOD_S / 2)))


class WantedMargins:
    """The margins that nodes keep, asked for in a thread of its own: a node may take its time to answer."""

    def __init__(self) -> None:
        self._wanted: dict[str, float] = {}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="wanted", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join()

    def wanted_margin(self, node: str) -> float | None:
        """Return the margin that ``node`` keeps, None = not known."""
        return self._wanted.get(node)

    def _run(self) -> None:
        while not self._stop.wait(0.2 if not self._wanted else ASK_PERIOD):
            found = {}
            for entry in running_nodes():
                try:
                    rows = {row["name"]: row["value"] for row in ask(entry, "parameters", ASK_PATIENCE)}
                except VegripError:
                    continue
                if isinstance(wanted := rows.get("grip.wanted_margin"), float):
                    found[entry.name] = wanted
            self._wanted = found


def run(port: int, announce: Callable[[str], None], *, opens: bool = False) -> None:
    """Hear all nodes of this machine, those that come later as well, and serve the page that shows them.

    Raises:
        DeviceError: the port is in use.

    """
    with closing(Stream()) as stream:
        stream.start()
        serve(routes(stream.log), port, announce, opens=opens)
