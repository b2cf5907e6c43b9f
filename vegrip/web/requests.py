"""What pages ask of their server: small JSON objects."""

import json
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request

from vegrip.errors import UsageError

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
