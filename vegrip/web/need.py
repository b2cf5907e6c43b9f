"""What the pages need beyond the core."""

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
