"""CURVE keys of ZeroMQ: who we are, whom we talk to, who may talk to us."""

from dataclasses import dataclass
from pathlib import Path

import zmq
from zmq.auth.thread import ThreadAuthenticator

from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.transport.key_files import read_keys


@dataclass(frozen=True)
class Curve:
    """The ``[transport.curve]`` table; ``vegrip keys`` makes the files."""

    own: str = parameter(doc="file with our secret key (NAME.key_secret)")
    peers: str = parameter(doc="folder with the public keys (NAME.key) of the subscribers that are allowed")
    publisher: str = parameter(doc="file with the public key (NAME.key) of those we subscribe to")


class Keys:
    """Loaded keys, ready to be put on sockets.

    Raises:
        ConfigError: a key file is missing or not one, or a secret that others can read.

    """

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
        """End the thread that checks keys."""
        if self._authenticator is not None:
            self._authenticator.stop()
            self._authenticator = None
