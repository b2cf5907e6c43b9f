"""The live page of messages that a program has at hand, such as the demonstration: no telemetry is heard."""

import threading
import time

import uvicorn

from vegrip.clock import NS
from vegrip.errors import DeviceError
from vegrip.messages import Message
from vegrip.runtime.monitor.board import Board
from vegrip.web.live.columns import COLUMN_PERIOD_S
from vegrip.web.live.event_log import EventLog
from vegrip.web.live.page import routes
from vegrip.web.live.view import LiveView
from vegrip.web.server import guarded, listening

LOOKED_AT_S = 2.0  # [s] after the last look of a page in which messages are taken


class FedPage:
    """Serves the live page from a thread; costs nothing while it is not looked at.

    Args:
        wanted_margin: that the node keeps.
        port: to listen on; any free one where it is in use.

    """

    def __init__(self, wanted_margin: float, port: int) -> None:
        self._wanted = wanted_margin
        self._log = EventLog(LiveView(Board(time.monotonic_ns())))
        self._looked = self._due = 0.0
        try:
            self._listener = listening(port)
        except DeviceError:
            self._listener = listening(0)
        app, self.address = guarded(routes(self), self._listener)
        config = uvicorn.Config(
            app, log_config=None, lifespan="off", access_log=False, timeout_graceful_shutdown=1
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._serve, name="page", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Serve no more."""
        self._server.should_exit = True
        self._thread.join()
        self._listener.close()

    def take(self, message: Message, now: int, node: str) -> None:
        """Take a message that came at ``now`` [ns]; dropped while no page looks."""
        if now / NS - self._looked < LOOKED_AT_S:
            self._log.view.take(message, now, node)

    def tick(self) -> None:
        """Make the next event, when it is due and a page looks; called by the thread that takes."""
        now = time.monotonic()
        if now >= self._due and now - self._looked < LOOKED_AT_S:
            self._due = now + COLUMN_PERIOD_S
            self._log.tick(time.monotonic_ns(), self)

    def wanted_margin(self, node: str) -> float | None:
        del node
        return self._wanted

    @property
    def number(self) -> int:
        self._looked = time.monotonic()
        return self._log.number

    def first(self) -> tuple[int, str]:
        self._looked = time.monotonic()
        return self._log.first()

    def since(self, number: int) -> tuple[int, str]:
        """Return number and text of the event with what is new since the event ``number``."""
        return self._log.since(number)

    def _serve(self) -> None:
        self._server.run(sockets=[self._listener])
