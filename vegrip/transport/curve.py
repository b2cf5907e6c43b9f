"""CURVE keys of ZeroMQ: who we are, whom we talk to, who may talk to us."""

import ipaddress
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import zmq
from zmq.auth.thread import ThreadAuthenticator

from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.host.folders import LONGEST_SOCKET, socket_path, why_not_private, why_not_trusted
from vegrip.transport.key_files import read_keys

NAME: Final = re.compile(r"[A-Za-z0-9_\-][A-Za-z0-9_.\-]*")
ABSTRACT: Final = "@"
"""First character of a name that is no file: it has no permissions, any user may connect or bind it first."""


def resolve(address: str) -> str:
    """Return the ZeroMQ address of ``address``; ``ipc:NAME`` is a socket in the user's private folder."""
    scheme, _, rest = address.partition(":")
    if scheme == "ipc" and rest and not rest.startswith("//"):
        if not NAME.fullmatch(rest):
            raise ConfigError(
                f"{address!r} is no address: in ipc:NAME the name consists of letters, digits, '_', '-' "
                "and '.', and does not begin with '.'"
            )
        return f"ipc://{socket_path('zmq', rest)}"
    path = rest.removeprefix("//")
    if scheme not in ("ipc", "tcp") or not rest.startswith("//") or not path.isprintable() or not path:
        raise ConfigError(f"{address!r} is no address; write ipc:NAME, ipc:///path or tcp://127.0.0.1:PORT")
    if scheme == "ipc":
        # a name without a file is a path too, but only with keys
        if not path.startswith(("/", ABSTRACT)) or ".." in Path(path).parts:
            raise ConfigError(f"{path!r} is no path of a socket; use ipc:NAME, or a full path without '..'")
        if len(os.fsencode(path)) > LONGEST_SOCKET:
            raise ConfigError(
                f"{path} is too long for a socket (at most {LONGEST_SOCKET} bytes); use ipc:NAME"
            )
    return address


def is_local(address: str) -> bool:
    """Whether a resolved ``address`` is one of this machine and, if it is a file, of this user alone."""
    if address.startswith("ipc://"):
        path = address.removeprefix("ipc://")
        return not path.startswith(ABSTRACT) and _is_private(Path(path).parent)
    host = address.removeprefix("tcp://").rpartition(":")[0].strip("[]")
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:  # a name, an interface or *
        return False


def check_reach(address: str, encrypted: bool) -> None:
    """Refuse an address that others can reach without keys."""
    if encrypted or is_local(address):
        return
    if address.startswith("ipc://"):
        raise ConfigError(
            f"{address} can be reached by other users, or lies where they can put a socket of theirs; use "
            "ipc:NAME, a folder that only you can enter (chmod 700), or a [transport.curve] table with keys"
        )
    raise ConfigError(
        f"{address} can be reached from other machines; add a [transport.curve] table with keys, "
        "or use tcp://127.0.0.1:PORT or ipc:NAME"
    )


def _is_private(folder: Path) -> bool:
    try:
        return not (why_not_private(folder) or why_not_trusted(folder))
    except OSError:
        return False


@dataclass(frozen=True)
class Curve:
    """The ``[transport.curve]`` table; ``vegrip keys`` makes the files."""

    own: str = parameter(doc="file with our secret key (NAME.key_secret)")
    peers: str = parameter(doc="folder with the public keys (NAME.key) of the subscribers that are allowed")
    publisher: str = parameter(doc="file with the public key (NAME.key) of those we subscribe to")


class Keys:
    """Loaded keys, ready to be put on sockets."""

    def __init__(self, settings: Curve) -> None:
        self._public, self._secret = read_keys(Path(settings.own))
        if self._secret is None:
            raise ConfigError(f"{settings.own} has no secret key; give the file that ends in .key_secret")
        self._publisher, _ = read_keys(Path(settings.publisher))
        self._peers = Path(settings.peers)
        if not self._peers.is_dir():
            raise ConfigError(f"{self._peers} is no folder; put the public keys of the subscribers there")
        self._authenticator: ThreadAuthenticator | None = None

    def guard(self, context: zmq.Context[zmq.Socket[bytes]]) -> None:
        """Let sockets of ``context`` that serve accept the peers only."""
        self._authenticator = ThreadAuthenticator(context)
        self._authenticator.start()
        self._authenticator.configure_curve(domain="*", location=str(self._peers))

    def serve(self, publisher: zmq.Socket[bytes]) -> None:
        """Make ``publisher`` encrypt and ask its subscribers for their keys."""
        publisher.curve_secretkey, publisher.curve_publickey = self._secret, self._public
        publisher.curve_server = True

    def subscribe(self, subscriber: zmq.Socket[bytes]) -> None:
        """Make ``subscriber`` show our key and insist on the publisher's."""
        subscriber.curve_secretkey, subscriber.curve_publickey = self._secret, self._public
        subscriber.curve_serverkey = self._publisher

    def close(self) -> None:
        if self._authenticator is not None:
            self._authenticator.stop()
            self._authenticator = None
