"""The routes of the check page."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from vegrip.errors import UsageError, VegripError
from vegrip.web.check.controller import Controller
from vegrip.web.check.render import body, commands, progress, verdict
from vegrip.web.requests import STATES, asked
from vegrip.web.server import STATIC, events

PERIOD = 0.25  # [s] between two looks at what is new


def routes(controller: Controller) -> list[Route]:
    """Return the routes of the check page."""
    actions: dict[str, Callable[[dict[str, Any]], None]] = {
        "judge": lambda _: controller.judge(),
        "add": lambda told: controller.add(str(told["effect"])),
        "undo": lambda _: controller.undo(),
        "look_at": lambda told: controller.look_at(int(told["place"])),
        "stop": lambda _: controller.stop(),
        "hold_back": lambda told: controller.hold_back(str(told["episodes"])),
        "compare_with": lambda told: controller.compare_with(_place(told["place"])),
        "compare_with_file": lambda told: controller.compare_with_file(str(told["name"])),
        "plan": lambda told: controller.plan(str(told["candidates"]), str(told["duration"])),
        "write_model": lambda told: controller.write_model(str(told["name"])),
        "use_in_node": lambda told: controller.use_in_node(str(told["node"])),
    }

    async def page(_: Request) -> Response:
        return FileResponse(STATIC / "check.html")

    async def live(_: Request) -> Response:
        return StreamingResponse(events(_texts(controller)), media_type="text/event-stream")

    async def act(request: Request) -> Response:
        try:
            told = await asked(request)
            if told.get("do") not in actions:
                raise UsageError("the page asks for what this server does not know; load it again")
            await run_in_threadpool(actions[told["do"]], told)
        except VegripError as error:
            return JSONResponse({"error": str(error)}, STATES.get(error.exit_code, 500))
        except (KeyError, ValueError) as error:
            return JSONResponse({"error": f"the request is not complete: {error}"}, 400)
        return JSONResponse({})

    async def motion(_: Request) -> Response:
        file = controller.motion()
        if file is None:
            return JSONResponse({"error": "no experiment was found yet"}, 404)
        return FileResponse(file, media_type="application/toml", filename=f"{controller.name}-next.toml")

    return [
        Route("/", page),
        Route("/live", live),
        Route("/motion", motion),
        Route("/do", act, methods=["POST"]),
    ]


def _place(told: Any) -> int | None:
    return None if told == "before" else int(told)


async def _texts(controller: Controller) -> AsyncIterator[str]:
    version, shown = -1, ""
    while True:
        told: dict[str, Any] = {"progress": _progress(controller)}
        if controller.version != version:
            version = controller.version
            told |= _whole(controller)
        text = json.dumps(told)
        if text != shown:
            shown = text
            yield text
        await asyncio.sleep(PERIOD)


def _progress(controller: Controller) -> str:
    job = controller.job
    return "" if job is None else progress(controller.what, job.elapsed, job.lines)


def _whole(controller: Controller) -> dict[str, Any]:
    session = controller.session
    rung = session.rung
    level, name, _ = verdict(rung) if rung is not None else ("unknown", "fitting", "")
    return {
        "recording": controller.name,
        "level": level,
        "verdict": name,
        "body": body(
            session,
            busy=controller.job is not None,
            beside=controller.beside,
            other=controller.other,
            node=controller.node,
        ),
        "commands": commands(controller.commands),
        "error": controller.error,
        "note": controller.note,
    }
