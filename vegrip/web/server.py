"""Serve a page on loopback until it is asked to stop, to programs of this machine that know its key."""

import hmac
import json
import secrets
import socket
import webbrowser
from collections.abc import AsyncIterator, Callable, Sequence
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import BaseRoute, Mount
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from vegrip.errors import DeviceError, UsageError, VegripError

HOST = "127.0.0.1"
STATIC = Path(__file__).parent / "static"
FAREWELL = 1  # [s] pages have to take their leave


HOST_NAMES = ("127.0.0.1", "localhost")
HEADERS = {
    b"content-security-policy": b"default-src 'self'; style-src 'self' 'unsafe-inline'; "
    b"img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'self'",
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"cache-control": b"no-store",
}
NEEDS_KEY = "This page needs its key: open the address that vegrip has printed, with ?key= at its end.\n"


class Guard:
    """Refuses every request that does not show the key.

    The server listens on loopback, but so may be reached by every user of the machine and by every web site
    that is open in the browser. So a page is given only to who shows the key in its address, once; the
    browser then keeps it in a cookie that no other site can send. A request under another name than loopback
    is refused, so that a name made to point here (DNS rebinding) brings nothing.
    """

    def __init__(self, app: ASGIApp, key: str, port: int) -> None:
        self._app = app
        self._key = key
        self._cookie = f"vegrip-{port}"  # cookies do not distinguish ports
        self._hosts = {f"{name}:{port}" for name in HOST_NAMES}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        if headers.get("host", "") not in self._hosts:
            await PlainTextResponse("unknown host\n", 400)(scope, receive, send)
        elif self._is_key(_asked(scope)):
            response = RedirectResponse(scope["path"], 303)
            response.set_cookie(self._cookie, self._key, httponly=True, samesite="strict")
            await response(scope, receive, send)
        elif self._is_key(_kept(headers, self._cookie)) and self._is_same_origin(headers):
            await self._app(scope, receive, _with_headers(send))
        else:
            await PlainTextResponse(NEEDS_KEY, 403)(scope, receive, send)

    def _is_key(self, key: str) -> bool:
        return hmac.compare_digest(key.encode(), self._key.encode())

    def _is_same_origin(self, headers: Headers) -> bool:
        origin = headers.get("origin")
        return origin is None or origin.removeprefix("http://") in self._hosts


def _asked(scope: Scope) -> str:
    query = parse_qs(scope["query_string"].decode("latin-1"))
    return str(query.get("key", [""])[0])


def _kept(headers: Headers, name: str) -> str:
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(name)
    except CookieError:
        return ""
    return "" if cookie is None else str(cookie.value)


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", ()), *HEADERS.items()]
        await send(message)

    return sending


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
        announce: gets the address, with its key, once it can be opened.
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
    """Return a socket that listens on loopback."""
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
    def __init__(self, config: uvicorn.Config, started: Callable[[], None]) -> None:
        super().__init__(config)
        self._has_started = started

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self._has_started()


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
        answer = json.loads(await _body(request))
    except (ValueError, RecursionError):  # also a thousand brackets
        answer = None
    if not isinstance(answer, dict):
        raise UsageError("the request is no JSON object")
    return answer


def answering(call: Callable[[dict[str, Any]], Any]) -> Callable[[Request], Any]:
    """Return an endpoint that answers JSON: what ``call`` returns, or one sentence and the exit code."""

    async def endpoint(request: Request) -> Response:
        try:
            return JSONResponse(await run_in_threadpool(call, await asked(request)))
        except VegripError as error:
            sentence, code = str(error), error.exit_code
        except KeyError as missing:
            sentence, code = f"the request lacks {missing}", UsageError.exit_code
        except ValueError as error:
            sentence, code = f"the request is not complete: {error}", UsageError.exit_code
        status = STATUS_OF_EXIT_CODE.get(code, 500)
        return JSONResponse({"error": sentence, "exit_code": code}, status)

    return endpoint


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
