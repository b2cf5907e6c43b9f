"""What ``proto/messages.toml`` says of every message: fields, types, topics, version.

Both codecs are built from these declarations: msgpack from them alone, CAN from them (meaning) and
``proto/fingertip.dbc`` (layout).
"""

import enum
from collections.abc import Mapping
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
    on_can: bool = True
    batch: str = ""  # topic on which the messages of all fingers travel together, "" = none

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
    """Return the text of a file of ``proto/``, wherever it is installed."""
    return resources.files(PROTO).joinpath(name).read_text(encoding="utf-8")


@cache
def message_set() -> MessageSet:
    """Read ``messages.toml`` (once)."""
    return parse(read_proto("messages.toml"))


def parse(text: str) -> MessageSet:
    """Build the message set from the text of ``messages.toml``.

    Raises:
        ConfigError: a message or a type that vegrip.messages does not have.

    """
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
