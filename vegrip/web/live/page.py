"""The routes of the live page: the page, its events, and what can be asked of a node."""

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any, Protocol

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from vegrip.errors import VegripError
from vegrip.runtime.client import CONFIGURING_MAY_TAKE, ask
from vegrip.runtime.registry import find_node
from vegrip.web.live.columns import COLUMN_PERIOD_S
from vegrip.web.requests import STATUS_OF_EXIT_CODE, asked
from vegrip.web.server import STATIC, events


class Stream(Protocol):
    """The source of the events of the page."""

    @property
    def number(self) -> int:
        """The number of the newest event."""

    def first(self) -> tuple[int, str]:
        """Return number and text of the event for a page that has just come."""

    def since(self, number: int) -> tuple[int, str]:
        """Return number and text of the event with what is new since the event ``number``."""


def routes(stream: Stream) -> list[Route]:
    """Return the routes of the live page."""

    async def page(_: Request) -> Response:
        return FileResponse(STATIC / "live.html")

    async def live(_: Request) -> Response:
        return StreamingResponse(events(_texts(stream)), media_type="text/event-stream")

    return [
        Route("/", page),
        Route("/live", live),
        Route("/parameters", _answers(_parameters), methods=["GET"]),
        Route("/parameters", _answers(_set_parameter), methods=["POST"]),
        Route("/state", _answers(_state), methods=["GET"]),
        Route("/state", _answers(_set_state), methods=["POST"]),
    ]


async def _texts(stream: Stream) -> AsyncIterator[str]:
    number, text = stream.first()
    yield text
    while True:
        await asyncio.sleep(COLUMN_PERIOD_S / 2)
        if stream.number > number:
            number, text = stream.since(number)
            yield text


def _parameters(told: dict[str, Any]) -> Any:
    return [_finite(row) for row in ask(find_node(told["node"]), "parameters")]


def _set_parameter(told: dict[str, Any]) -> Any:
    rows = ask(find_node(told["node"]), "set_parameter", name=told["name"], value=told["value"])
    return [_finite(row) for row in rows]


def _state(told: dict[str, Any]) -> Any:
    return ask(find_node(told["node"]), "state")


def _set_state(told: dict[str, Any]) -> Any:
    return ask(find_node(told["node"]), "set_state", CONFIGURING_MAY_TAKE, target=told["target"])


def _answers(call: Callable[[dict[str, Any]], Any]) -> Callable[[Request], Any]:
    """Return an endpoint that answers JSON: what ``call`` returns, or one sentence and the exit code."""

    async def endpoint(request: Request) -> Response:
        try:
            return JSONResponse(await run_in_threadpool(call, await asked(request)))
        except VegripError as error:
            sentence = {"error": str(error), "exit_code": error.exit_code}
            return JSONResponse(sentence, STATUS_OF_EXIT_CODE.get(error.exit_code, 500))
        except KeyError as missing:
            return JSONResponse({"error": f"the request lacks {missing}", "exit_code": 2}, 400)

    return endpoint


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    infinite = (float("inf"), -float("inf"))
    return {key: None if value in infinite or value != value else value for key, value in row.items()}  # noqa: PLR0124 (NaN)
