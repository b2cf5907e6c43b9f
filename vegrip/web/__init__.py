"""Pages for a browser on this machine: what is shown, the server, and what the browser loads.

``live`` shows running nodes. What is shown is worked out by pure functions; ``server`` and ``guard`` are the
rim. No node imports anything of this.
"""

from importlib.util import find_spec

from vegrip.errors import UsageError


def require_web() -> None:
    """Say what to install where the pages cannot be served.

    Raises:
        UsageError: starlette or uvicorn is not installed.

    """
    missing = [name for name in ("starlette", "uvicorn") if find_spec(name) is None]
    if missing:
        raise UsageError(f"pages need {' and '.join(missing)}; pip install 'vegrip[web]'")
