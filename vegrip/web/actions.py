"""The routes of a page that shows what a server has made, and says what was pressed."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from vegrip.errors import UsageError, VegripError
from vegrip.web.requests import STATUS_OF_EXIT_CODE, asked
from vegrip.web.server import STATIC, events

LOOK_PERIOD_S = 0.25  # [s] between two looks at what is new

Actions = Mapping[str, Callable[[dict[str, Any]], None]]
"""What the page can ask for, by name; each is given what the page sent."""


class Shown(Protocol):
    """What a page shows."""

    @property
    def version(self) -> int:
        """Counts changes of the whole."""

    def progress(self) -> str:
        """Return what is going on, as HTML; empty: nothing."""

    def whole(self) -> dict[str, Any]:
        """Return everything else, for JSON."""


def action_routes(
    html: str, shown: Shown, actions: Actions, motion: Callable[[], Path | None]
) -> list[Route]:
    """Return the routes: the page, its events, what it may ask for, and the motion that was found as a file.

    Args:
        html: name of the static file.
        shown: what it shows.
        actions: what it can ask for.
        motion: returns the file of the next experiment or trial, None where there is none.

    """

    async def page(_: Request) -> Response:
        return FileResponse(STATIC / html)

    async def live(_: Request) -> Response:
        return StreamingResponse(events(_texts(shown)), media_type="text/event-stream")

    async def act(request: Request) -> Response:
        try:
            told = await asked(request)
            if told.get("do") not in actions:
                raise UsageError("the page asks for what this server does not know; load it again")
            await run_in_threadpool(actions[told["do"]], told)
        except VegripError as error:
            return JSONResponse({"error": str(error)}, STATUS_OF_EXIT_CODE.get(error.exit_code, 500))
        except (KeyError, ValueError) as error:
            return JSONResponse({"error": f"the request is not complete: {error}"}, 400)
        return JSONResponse({})

    async def file(_: Request) -> Response:
        found = motion()
        if found is None:
            return JSONResponse({"error": "there is no motion yet"}, 404)
        return FileResponse(found, media_type="application/toml", filename=found.name)

    return [
        Route("/", page),
        Route("/live", live),
        Route("/motion", file),
        Route("/do", act, methods=["POST"]),
    ]


async def _texts(shown: Shown) -> AsyncIterator[str]:
    version, last = -1, ""
    while True:
        told: dict[str, Any] = {"progress": shown.progress()}
        if shown.version != version:
            version = shown.version
            told |= shown.whole()
        text = json.dumps(told)
        if text != last:
            last = text
            yield text
        await asyncio.sleep(LOOK_PERIOD_S)
