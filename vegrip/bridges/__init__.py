"""Bridges to programs of others, fed by the telemetry that nodes publish already. No other room imports this.

A bridge is a process of its own: it hears what ``vegrip topic echo`` hears, and a node neither waits for it
nor knows of it.
"""

from importlib.util import find_spec

from vegrip.errors import UsageError


def require_websockets() -> None:
    """Say what to install where Foxglove cannot be served.

    Raises:
        UsageError: websockets is not installed.

    """
    if find_spec("websockets") is None:
        raise UsageError("the bridge to Foxglove needs websockets; pip install 'vegrip[foxglove]'")
