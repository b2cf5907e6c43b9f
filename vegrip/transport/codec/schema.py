"""What ``proto/messages.toml`` says of every message: fields, types, topics, version.

Both codecs are built from these declarations: msgpack from them alone, CAN from them (meaning) and
``proto/fingertip.dbc`` (layout).
"""

import enum
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any, Final, get_args

from vegrip import messages
from vegrip.config import build, parse_toml
from vegrip.errors import ConfigError
from vegrip.messages import Message

PROTO: Final = "vegrip.proto"
FIELD_KINDS: Final = ("time", "sequence", "name", "float", "flag", "count", "text", "estimate", "counts")
Enumeration = type[enum.IntEnum] | type[enum.IntFlag]

CLASSES: Final[Mapping[str, type[Any]]] = {cls.__name__: cls for cls in get_args(Message)}


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message; ``kind`` is one of ``FIELD_KINDS`` or the name of an enumeration."""

    name: str
    kind: str
    unit: str = ""
    required: bool = False
    infinite: bool = False

    @property
    def enumeration(self) -> Enumeration | None:
        """The enumeration whose integer is carried, None for a plain kind."""
        return None if self.kind in FIELD_KINDS else getattr(messages, self.kind)


@dataclass(frozen=True, slots=True)
class MessageSchema:
    """One kind of message."""

    cls: type[Any]
    topic: str  # with the place holder {finger}
    fields: tuple[Field, ...]
    on_can: bool
    batch: str  # topic on which the messages of all fingers travel together, "" = none

    @property
    def owner(self) -> str:
        """The field that names whose message it is: ``finger`` or ``node``."""
        return next(f.name for f in self.fields if f.kind == "name")


@dataclass(frozen=True, slots=True)
class MessageSet:
    """All kinds of messages of one version."""

    version: int
    messages: Mapping[type[Any], MessageSchema]


def read_proto(name: str) -> str:
    return resources.files(PROTO).joinpath(name).read_text(encoding="utf-8")


@cache
def message_set() -> MessageSet:
    return parse(read_proto("messages.toml"))


def parse(text: str) -> MessageSet:
    table = parse_toml(text)
    version = table.pop("version")
    schemas = [_message(name, entry) for name, entry in table.items()]
    return MessageSet(version, {schema.cls: schema for schema in schemas})


def _message(name: str, entry: Mapping[str, Any]) -> MessageSchema:
    if name not in CLASSES:
        raise ConfigError(f"messages.toml: there is no message {name!r}; there are {', '.join(CLASSES)}")
    fields = tuple(_field(key, value, f"messages.toml [{name}]") for key, value in entry["fields"].items())
    on_can, batch = entry.get("can", True), entry.get("batch", "")
    return MessageSchema(CLASSES[name], entry["topic"], fields, on_can, batch)


def _field(name: str, entry: Mapping[str, Any], where: str) -> Field:
    entry = {"kind" if key == "type" else key: value for key, value in entry.items()}
    field = build(Field, {"name": name, **entry}, where)
    if field.kind not in FIELD_KINDS and not hasattr(messages, field.kind):
        raise ConfigError(
            f"{where}: {name!r} has the unknown type {field.kind!r}; known are {', '.join(FIELD_KINDS)}"
        )
    return field


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
    return zlib.crc32(topic.encode())


class Topics:
    """The topics of one hand."""

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
