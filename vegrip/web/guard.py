"""Who may see a page: only programs of this machine that know the key of this server.

The server listens on loopback, but so may be reached by every user of the machine and by every web site that
is open in the browser. So a page is given only to who shows the key in its address, once; the browser then
keeps it in a cookie that no other site can send. A request under another name than loopback is refused, so
that a name made to point here (DNS rebinding) brings nothing.
"""

import hmac
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

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

    Args:
        app: what is guarded.
        key: of this server.
        port: that it listens on.

    """

    def __init__(self, app: ASGIApp, key: str, port: int) -> None:
        self._app = app
        self._key = key
        self._cookie = f"vegrip-{port}"  # cookies do not tell ports apart
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
