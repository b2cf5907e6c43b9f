"""What pages ask of their server: small JSON objects."""

from typing import Any

from starlette.requests import Request

from vegrip.errors import UsageError

STATUS_OF_EXIT_CODE = {2: 400, 3: 422, 4: 503}
"""HTTP status for the exit code that the command line would have."""
MAX_REQUEST_BYTES = 10_000  # [bytes] of a request


async def asked(request: Request) -> dict[str, Any]:
    """Return the query of a GET or the JSON object of a POST.

    Raises:
        UsageError: the body is none.

    """
    if request.method == "GET":
        return dict(request.query_params)
    body = await request.body()
    try:
        told = await request.json() if len(body) <= MAX_REQUEST_BYTES else None
    except ValueError:
        told = None
    if not isinstance(told, dict):
        raise UsageError("the request is no JSON object")
    return told
