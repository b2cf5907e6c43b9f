"""Topics <-> kinds of messages, from the table in ``messages.toml``.

A namespace stands in front of every topic (``/left/hand/thumb/state``): it is the hand. A remapping gives a
topic another name on the wire. The Data ID of the protection is the CRC-32 of the name on the wire, so that a
message on another hand's topic is refused.
"""

import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from vegrip.errors import ConfigError
from vegrip.transport.codec.schema import MessageSchema, message_set

PLACE: Final = "{finger}"
FINGER: Final = r"[A-Za-z0-9_\-.]{1,64}"
NAMESPACE: Final = re.compile(r"[A-Za-z0-9_\-./]*")
ROUTES: Final = 1024
"""Topics kept when any finger's name is accepted; a flood of names must not eat the memory."""


@dataclass(frozen=True, slots=True)
class Route:
    """A topic on the wire and what travels on it."""

    topic: str
    schema: MessageSchema
    owner: str | None  # the finger; None where the message alone says whose it is
    data_id: int


def data_id_of(topic: str) -> int:
    """Return the Data ID of what travels on a topic of the wire."""
    return zlib.crc32(topic.encode())


class Topics:
    """The topics of one hand.

    Args:
        namespace: in front of every topic, "" for none.
        fingers: names of the fingers, None accepts any.
        remap: names of this program -> names on the wire, both without the namespace left out.

    Raises:
        ConfigError: a namespace or a finger's name that cannot stand in a topic.

    """

    def __init__(
        self,
        namespace: str = "",
        fingers: Sequence[str] | None = None,
        remap: Mapping[str, str] | None = None,
    ) -> None:
        if not NAMESPACE.fullmatch(namespace):
            raise ConfigError(
                f"the namespace {namespace!r} must consist of letters, digits, '_', '-', '.' and '/'"
            )
        bad = [name for name in fingers or () if not re.fullmatch(FINGER, name)]
        if bad:
            raise ConfigError(
                f"the finger's name {bad[0]!r} must consist of letters, digits, '_', '-' and '.'"
            )
        self.prefix = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
        self._fingers = None if fingers is None else frozenset(fingers)
        self._remap = dict(remap or {})
        self._inverse = {wire: name for name, wire in self._remap.items()}
        self._patterns = [(_pattern(self.prefix, s.topic), s) for s in message_set().messages.values()]
        self._incoming: dict[str, Route] = {}
        self._outgoing: dict[tuple[type[Any], str], Route] = {}

    def outgoing(self, cls: type[Any], owner: str) -> Route | None:
        """Return the route of a message, None for a finger that is not configured."""
        route = self._outgoing.get((cls, owner))
        if route is None:
            schema = message_set().messages[cls]
            name = self.prefix + schema.topic.replace(PLACE, owner)
            route = self._route(self._remap.get(name, name))
            if route is not None and len(self._outgoing) < ROUTES:
                self._outgoing[cls, owner] = route
        return route

    def incoming(self, topic: str) -> Route | None:
        """Return what travels on the topic ``topic`` of the wire, None when it is not ours."""
        route = self._incoming.get(topic)
        if route is None:
            route = self._route(topic)
            if route is not None and len(self._incoming) < ROUTES:
                self._incoming[topic] = route
        return route

    def _route(self, topic: str) -> Route | None:
        name = self._inverse.get(topic, topic)
        for pattern, schema in self._patterns:
            match = pattern.fullmatch(name)
            if match:
                owner = match.groupdict().get("finger")
                known = owner is None or self._fingers is None or owner in self._fingers
                return Route(topic, schema, owner, data_id_of(topic)) if known else None
        return None


def _pattern(prefix: str, topic: str) -> re.Pattern[str]:
    return re.compile(re.escape(prefix) + re.escape(topic).replace(re.escape(PLACE), f"(?P<finger>{FINGER})"))
