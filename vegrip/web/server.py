"""Serve a page on loopback until it is told to stop."""

import json
import secrets
import socket
import webbrowser
from collections.abc import AsyncIterator, Callable, Sequence
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.routing import BaseRoute, Mount
from starlette.staticfiles import StaticFiles

from vegrip.errors import DeviceError, UsageError
from vegrip.web.guard import Guard

HOST = "127.0.0.1"
STATIC = Path(__file__).parent / "static"
FAREWELL = 1  # [s] pages have to take their leave


def serve(
    routes: Sequence[BaseRoute],
    port: int,
    announce: Callable[[str], None],
    *,
    opens: bool = False,
) -> None:
    """Serve ``routes`` and the static files on loopback until the process is interrupted.

    Args:
        routes: of the page.
        port: to listen on, 0 = any that is free.
        announce: told the address, with its key, once it can be opened.
        opens: whether to open it in the browser.

    Raises:
        DeviceError: the port is in use.

    """
    with listening(port) as listener:
        app, address = guarded(routes, listener)
        server = _Server(
            uvicorn.Config(
                app, log_config=None, lifespan="off", access_log=False, timeout_graceful_shutdown=FAREWELL
            ),
            lambda: _announce(address, announce, opens=opens),
        )
        server.run(sockets=[listener])


def guarded(routes: Sequence[BaseRoute], listener: socket.socket) -> tuple[Guard, str]:
    """Return the application of ``routes`` behind a key of its own, and its address with the key."""
    port = listener.getsockname()[1]
    key = secrets.token_urlsafe(16)
    app = Starlette(routes=[*routes, Mount("/static", StaticFiles(directory=STATIC))])
    return Guard(app, key, port), f"http://{HOST}:{port}/?key={key}"


def listening(port: int) -> socket.socket:
    """Return a socket that listens on loopback.

    Raises:
        DeviceError: the port is in use.

    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
        listener.listen()
    except (OSError, OverflowError) as error:
        listener.close()
        raise DeviceError(
            f"port {port} of {HOST} cannot be used ({error}); give another with --port, or 0 for any free one"
        ) from None
    return listener


class _Server(uvicorn.Server):
    """Tells when it can be reached."""

    def __init__(self, config: uvicorn.Config, started: Callable[[], None]) -> None:
        super().__init__(config)
        self._tell_started = started

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self._tell_started()


def _announce(address: str, announce: Callable[[str], None], *, opens: bool) -> None:
    announce(address)
    if opens:
        webbrowser.open(address)


async def events(texts: AsyncIterator[str]) -> AsyncIterator[str]:
    async for text in texts:
        yield f"data: {text}\n\n"


STATUS_OF_EXIT_CODE = {2: 400, 3: 422, 4: 503}
"""HTTP status for the exit code that the command line would have."""
MAX_REQUEST_BYTES = 10_000  # [bytes] of a request


async def asked(request: Request) -> dict[str, Any]:
    """Return the query of a GET or the JSON object of a POST.

    Raises:
        HTTPException: the body is larger than ``MAX_REQUEST_BYTES``; no more than that is read of it.
        UsageError: the body is none.

    """
    if request.method == "GET":
        return dict(request.query_params)
    try:
        told = json.loads(await _body(request))
    except (ValueError, RecursionError):  # also a thousand brackets
        told = None
    if not isinstance(told, dict):
        raise UsageError("the request is no JSON object")
    return told


async def _body(request: Request) -> bytes:
    too_large = HTTPException(413, f"the request has more than {MAX_REQUEST_BYTES} bytes")
    if int(request.headers.get("content-length", "0")) > MAX_REQUEST_BYTES:
        raise too_large
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MAX_REQUEST_BYTES:
            raise too_large
    return body
