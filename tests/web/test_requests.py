"""What a page sends is small JSON, and no more of it is read than that."""

import asyncio
import json

import pytest
from starlette.exceptions import HTTPException
from starlette.requests import Request

from vegrip.errors import UsageError
from vegrip.web.server import MAX_REQUEST_BYTES, asked

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
