"""Bridges to programs of others, fed by the telemetry that nodes publish already. No other room imports this.

A bridge is a process of its own: it receives what ``vegrip topic echo`` receives, and a node neither waits
for it nor knows of it.
"""

from importlib.util import find_spec

from vegrip.errors import UsageError


def require(module: str, what: str, extra: str) -> None:
    """Say what to install where ``module`` is not.

    Raises:
        UsageError: it is not installed.

    """
    if find_spec(module) is None:
        raise UsageError(f"{what} needs {module}; pip install 'vegrip[{extra}]'")
