"""Where ZeroMQ sockets listen and connect: names for this machine, and nothing beyond it unless encrypted."""

import ipaddress
import os

from vegrip.errors import ConfigError
from vegrip.transport.runtime_folder import LONGEST_SOCKET, socket_path


def resolve(address: str) -> str:
    """Return the ZeroMQ address of ``address``; ``ipc:NAME`` is a socket in the private folder of the user.

    Raises:
        ConfigError: it is no address ZeroMQ knows, or its path is too long.

    """
    scheme, _, rest = address.partition(":")
    if scheme == "ipc" and rest and not rest.startswith("/"):
        return f"ipc://{socket_path('zmq', rest)}"
    if scheme not in ("ipc", "tcp") or not rest.startswith("//") or len(rest) == len("//"):
        raise ConfigError(f"{address!r} is no address; write ipc:NAME, ipc:///path or tcp://127.0.0.1:PORT")
    path = rest[len("//") :]
    if scheme == "ipc" and len(os.fsencode(path)) > LONGEST_SOCKET:
        raise ConfigError(f"{path} is too long for a socket (at most {LONGEST_SOCKET} bytes); use ipc:NAME")
    return address


def is_local(address: str) -> bool:
    """Whether a resolved ``address`` can be reached from this machine only."""
    if address.startswith("ipc://"):
        return True
    host = address.removeprefix("tcp://").rpartition(":")[0].strip("[]")
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:  # a name, an interface or *
        return False


def check_reach(address: str, encrypted: bool) -> None:
    """Refuse an address beyond this machine without keys.

    Raises:
        ConfigError: with the remedy.

    """
    if not (encrypted or is_local(address)):
        raise ConfigError(
            f"{address} can be reached from other machines; add a [transport.curve] table with keys, "
            "or use tcp://127.0.0.1:PORT or ipc:NAME"
        )
