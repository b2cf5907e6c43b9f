"""A page is shown only on loopback, under a name of loopback, and to who knows its key."""

import asyncio
import json
import socket

import pytest
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import PlainTextResponse

from vegrip.errors import DeviceError, UsageError
from vegrip.web.server import MAX_REQUEST_BYTES, Guard, asked, listening

KEY = "the key"


def ask(headers: dict[str, str], query: str = "") -> tuple[int, dict[str, str]]:
    """Return status and headers of the answer to one request."""
    sent: list[dict] = []

    async def receive() -> dict:
        return {"type": "http.request"}

    async def send(message: dict) -> None:
        sent.append(message)

    scope = {
        "type": "http",
        "method": "GET",
        "path": "/",
        "query_string": query.encode(),
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
    }
    asyncio.run(Guard(PlainTextResponse("shown"), KEY, 8000)(scope, receive, send))
    return sent[0]["status"], {name.decode(): value.decode() for name, value in sent[0]["headers"]}


HERE = {"host": "127.0.0.1:8000"}
KNOWN = HERE | {"cookie": f'vegrip-8000="{KEY}"'}


def test_who_shows_the_key_gets_a_cookie_that_other_sites_cannot_send() -> None:
    status, headers = ask(HERE, "key=the+key")
    assert status == 303
    assert headers["location"] == "/"
    assert "HttpOnly" in headers["set-cookie"]
    assert "SameSite=strict" in headers["set-cookie"]


def test_with_the_cookie_the_page_is_shown_and_may_load_nothing_from_elsewhere() -> None:
    status, headers = ask(KNOWN)
    assert status == 200
    assert headers["content-security-policy"].startswith("default-src 'self'")


@pytest.mark.parametrize(
    ("headers", "query"),
    [
        (HERE, ""),
        (HERE, "key=another"),
        (HERE, "key="),
        (HERE | {"cookie": "vegrip-8000=another"}, ""),
        (HERE | {"cookie": f'vegrip-8001="{KEY}"'}, ""),
        (HERE | {"cookie": "\x00;;=bad"}, ""),
        (KNOWN | {"origin": "http://evil.example"}, ""),
    ],
)
def test_all_others_are_refused(headers: dict[str, str], query: str) -> None:
    assert ask(headers, query)[0] == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:8001", ""])
def test_under_another_name_nothing_is_shown(host: str) -> None:
    assert ask(KNOWN | {"host": host})[0] == 400


def test_the_server_listens_on_loopback_alone() -> None:
    with listening(0) as listener:
        assert listener.getsockname()[0] == "127.0.0.1"


def test_a_port_in_use_is_one_sentence() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(DeviceError, match=f"port {port} of 127.0.0.1 cannot be used"):
            listening(port)


PART = 1000  # [bytes] that arrive at once


def post(body: bytes, told: str | None = None) -> tuple[object, int]:
    """Return what is made of a POST, and how many bytes of it were read."""
    parts = [body[at : at + PART] for at in range(0, len(body), PART)] or [b""]
    read = 0

    async def receive() -> dict:
        nonlocal read
        part = parts.pop(0)
        read += len(part)
        return {"type": "http.request", "body": part, "more_body": bool(parts)}

    headers = [] if told is None else [(b"content-length", told.encode())]
    request = Request({"type": "http", "method": "POST", "path": "/do", "headers": headers}, receive)
    try:
        return asyncio.run(asked(request)), read
    except (UsageError, HTTPException) as error:
        return error, read


def test_a_small_object_is_taken_whole() -> None:
    told = {"do": "undo", "note": "x" * 5000}
    body = json.dumps(told).encode()
    assert post(body, str(len(body))) == (told, len(body))


@pytest.mark.parametrize("body", [b"[" * 9000, b'{"a":' * 1500, b"[]", b"", b"{", b"\xff"])
def test_what_is_no_object_is_refused_in_a_sentence(body: bytes) -> None:
    found, _ = post(body)
    assert isinstance(found, UsageError)


def test_a_length_beyond_the_bound_is_refused_before_anything_is_read() -> None:
    found, read = post(b"[" * 10**6, "1000000")
    assert isinstance(found, HTTPException)
    assert (found.status_code, read) == (413, 0)


@pytest.mark.parametrize("told", [None, "5"])
def test_a_body_that_is_longer_than_it_says_is_read_to_the_bound_only(told: str | None) -> None:
    found, read = post(b"[" * 10**6, told)
    assert isinstance(found, HTTPException)
    assert found.status_code == 413
    assert read <= MAX_REQUEST_BYTES + PART


@pytest.mark.parametrize("told", ["x", "9" * 5000])
def test_a_length_that_is_none_is_refused(told: str) -> None:
    found, read = post(b"{}", told)
    assert isinstance(found, UsageError | HTTPException)
    assert read == 0
