"""The thread that turns what it receives from the nodes into the events of the page, 25 a second."""

import asyncio
import threading
import time
from collections.abc import AsyncIterator, Callable
from contextlib import closing
from typing import Any

import uvicorn
from starlette.requests import Request
from starlette.responses import FileResponse, Response, StreamingResponse
from starlette.routing import Route

from vegrip import messages
from vegrip.clock import NS
from vegrip.errors import DeviceError, VegripError
from vegrip.jsonable import jsonable
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.watch import Watch
from vegrip.runtime.registry import CONFIGURING_MAY_TAKE, ask, find_node, running_nodes
from vegrip.web.live.view import COLUMN_PERIOD_S, EventLog, LiveView
from vegrip.web.server import STATIC, answering, events, guarded, listening, serve


def routes(stream: EventLog) -> list[Route]:
    async def page(_: Request) -> Response:
        return FileResponse(STATIC / "live.html")

    async def live(_: Request) -> Response:
        return StreamingResponse(events(_texts(stream)), media_type="text/event-stream")

    return [
        Route("/", page),
        Route("/live", live),
        Route("/parameters", answering(_parameters), methods=["GET"]),
        Route("/parameters", answering(_set_parameter), methods=["POST"]),
        Route("/state", answering(lambda asked: ask(find_node(asked["node"]), "state")), methods=["GET"]),
        Route("/state", answering(_set_state), methods=["POST"]),
    ]


async def _texts(stream: EventLog) -> AsyncIterator[str]:
    number, text = stream.first()
    yield text
    while True:
        await asyncio.sleep(COLUMN_PERIOD_S / 2)
        if stream.number > number:
            number, text = stream.since(number)
            yield text


def _parameters(asked: dict[str, Any]) -> Any:
    return jsonable(ask(find_node(asked["node"]), "parameters"))


def _set_parameter(asked: dict[str, Any]) -> Any:
    return jsonable(ask(find_node(asked["node"]), "set_parameter", name=asked["name"], value=asked["value"]))


def _set_state(asked: dict[str, Any]) -> Any:
    return ask(find_node(asked["node"]), "set_state", CONFIGURING_MAY_TAKE, target=asked["target"])


EVERY_ONE = (messages.SlipMargin, messages.LearnedParameter)
NEWEST_ONLY = (messages.ContactEstimate, messages.ForceCommand, messages.FingertipState, messages.ModelHealth)
"""One of these in 40 ms is as much as a screen shows; each that is sent costs the node time."""
ASK_PERIOD = 2.0  # [s] between two questions for the wanted margins
ASK_PATIENCE = 0.5  # [s]


class Stream:
    """Receives from all nodes of this machine in a thread of its own; pages read its ``log``."""

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
        self._stop.set()
        self._wishes.close()
        self._thread.join()
        self._watch.close()

    def _run(self) -> None:
        due = time.monotonic() + COLUMN_PERIOD_S
        while not self._stop.is_set():
            self._watch.step(self.log.view)
            if (now := time.monotonic()) >= due:
                self.log.add_event(time.monotonic_ns(), self._wishes.wanted_margin)
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
    """Receive from all nodes of this machine, also later ones, and serve the page that shows them."""
    with closing(Stream()) as stream:
        stream.start()
        serve(routes(stream.log), port, announce, opens=opens)


LOOKED_AT_S = 2.0  # [s] after the last look of a page in which messages are taken


class FedPage(EventLog):
    """Serves the live page from a thread; costs nothing while it is not looked at.

    Args:
        wanted_margin: that the node keeps.
        port: to listen on; any free one where it is in use.

    """

    def __init__(self, wanted_margin: float, port: int) -> None:
        super().__init__(LiveView(Board(time.monotonic_ns())))
        self._wanted = wanted_margin
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
        self._server.should_exit = True
        self._thread.join()
        self._listener.close()

    def receive(self, message: messages.Message, now: int, node: str) -> None:
        """Take a message that came at ``now`` [ns]; dropped while no page looks."""
        if now / NS - self._looked < LOOKED_AT_S:
            self.view.receive(message, now, node)

    def tick(self) -> None:
        """Make the next event, when it is due and a page looks; called by the thread that takes."""
        now = time.monotonic()
        if now >= self._due and now - self._looked < LOOKED_AT_S:
            self._due = now + COLUMN_PERIOD_S
            self.add_event(time.monotonic_ns(), lambda _: self._wanted)

    @property
    def number(self) -> int:
        self._looked = time.monotonic()
        return self._number

    def first(self) -> tuple[int, str]:
        self._looked = time.monotonic()
        return super().first()

    def _serve(self) -> None:
        self._server.run(sockets=[self._listener])
