"""How each kind of message lies in CAN frames: from ``proto/fingertip.dbc`` by way of cantools.

A message takes one frame, or several parts sent in order; the last one sent has its bit ``last`` set, so that
parts without anything measured at the end need not be sent.
"""

import dataclasses
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import gcd
from typing import Any

import cantools
from cantools.database.can import Database
from cantools.database.can import Message as DbcMessage

from vegrip.errors import ConfigError
from vegrip.transport.codec import signals
from vegrip.transport.codec.protection import CAN_PROFILES, COUNTER_MODULUS, Profile
from vegrip.transport.codec.schema import Field, MessageSchema, message_set, read_proto

HEADER = ("crc", "counter", "seq", "version", "last", "time")


@dataclass(frozen=True, slots=True)
class Slot:
    """One signal of the payload."""

    name: str
    field: Field
    text: str  # of its value in a message ``m``
    convert: signals.Converter
    place: signals.Place


@dataclass(frozen=True, slots=True)
class Part:
    """One frame of a message."""

    name: str
    number: int  # from 1
    base: int  # identifier for finger 0 of hand 0
    length: int
    fd: bool
    profile: Profile
    packer: struct.Struct
    counter: signals.Place
    modulus: int
    version: signals.Place
    version_modulus: int
    last: signals.Place | None
    time: signals.Place | None
    slots: tuple[Slot, ...]
    offset: int  # cells of the parts before this one
    cells: int

    @property
    def absent(self) -> signals.Cells:
        """The cells of a part that was not sent: nothing measured."""
        row: list[signals.Raw] = [0] * self.cells
        for slot in self.slots:
            slot.place.put(row, slot.convert.absent)
        return tuple(row)


@dataclass(frozen=True, slots=True)
class Layout:
    """A kind of message, classic or FD."""

    schema: MessageSchema
    fd: bool
    parts: tuple[Part, ...]
    reading: Sequence[str]
    """Lines that set ``values``, the fields after stamp, owner and seq, from the ``cells`` of all parts."""
    scope: Mapping[str, Any]
    """What those lines know."""


@dataclass(frozen=True, slots=True)
class Layouts:
    """All of the database."""

    version: int
    hand_stride: int
    finger_stride: int
    hands: int
    fingers: int
    layouts: tuple[Layout, ...]

    def block(self, base: int, hand: int) -> range:
        first = base + hand * self.hand_stride
        return range(first, first + self.fingers * self.finger_stride)


@cache
def database() -> Database:
    """Read ``fingertip.dbc`` with cantools (once)."""
    loaded = cantools.database.load_string(read_proto("fingertip.dbc"), database_format="dbc")
    if not isinstance(loaded, Database):
        raise ConfigError("fingertip.dbc is not a CAN database")
    return loaded


@cache
def layouts() -> Layouts:
    return build_layouts(database())


def build_layouts(db: Database) -> Layouts:
    """Return the layouts of all messages of ``db``.

    Identifiers come in blocks of one size, which the base identifiers are multiples of.
    """
    version, hand, finger = (
        _attribute(db, key) for key in ("MessageSetVersion", "HandStride", "FingerStride")
    )
    if version != message_set().version:
        raise ConfigError(f"fingertip.dbc has version {version}, messages.toml {message_set().version}")
    block = gcd(*(message.frame_id for message in db.messages))
    made = tuple(
        _layout(
            schema,
            fd,
            [m for m in db.messages if m.is_fd == fd and _attribute(m, "MessageName") == schema.cls.__name__],
        )
        for schema in message_set().messages.values()
        if schema.on_can
        for fd in (False, True)
    )
    return Layouts(version, hand, finger, block // hand, hand // finger, made)


def _layout(schema: MessageSchema, fd: bool, messages: list[DbcMessage]) -> Layout:
    parts: list[Part] = []
    for message in sorted(messages, key=lambda m: int(_attribute(m, "MessagePart"))):
        try:
            parts.append(_part(schema, message, sum(part.cells for part in parts)))
        except LookupError as error:
            raise ConfigError(f"fingertip.dbc: {message.name} has no {error}") from None
    if [part.number for part in parts] != list(range(1, len(parts) + 1)):
        raise ConfigError(
            f"fingertip.dbc: the parts of {schema.cls.__name__} must count from 1 without a gap"
        )
    return Layout(schema, fd, tuple(parts), *_reading(schema, parts))


def _part(schema: MessageSchema, message: DbcMessage, offset: int) -> Part:
    packer, places = signals.plan(message)
    counter = places["seq" if message.is_fd else "counter"]
    names = tuple(name for name in places if name not in HEADER)
    return Part(
        name=message.name,
        number=_attribute(message, "MessagePart"),
        base=message.frame_id,
        length=message.length,
        fd=message.is_fd,
        profile=_profile(message),
        packer=packer,
        counter=counter,
        modulus=1 << 32 if message.is_fd else COUNTER_MODULUS,
        version=places["version"],
        version_modulus=1 << message.get_signal_by_name("version").length,
        last=places.get("last"),
        time=places.get("time"),
        slots=tuple(_slot(schema, message, name, names, places[name]) for name in names),
        offset=offset,
        cells=1 + max(place.cell for place in places.values()),
    )


def _slot(
    schema: MessageSchema, message: DbcMessage, name: str, names: tuple[str, ...], place: signals.Place
) -> Slot:
    field = next((f for f in schema.fields if signals.belongs(f, name)), None)
    if field is None:
        raise ConfigError(
            f"fingertip.dbc: {message.name}.{name} belongs to no field of {schema.cls.__name__}"
        )
    signal = message.get_signal_by_name(name)
    return Slot(name, field, signals.value_text(field, name, names), signals.converter(field, signal), place)


def _reading(schema: MessageSchema, parts: list[Part]) -> tuple[list[str], dict[str, Any]]:
    lines, values = list[str](), list[str]()
    scope: dict[str, Any] = dict(signals.MAKERS)
    for field in schema.fields:
        if field.name in ("stamp", schema.owner, "seq"):
            continue
        texts: dict[str, str] = {}
        for part, slot in ((one, slot) for one in parts for slot in one.slots if slot.field is field):
            raw, rest = f"c{len(lines)}", f"r{len(lines)}"
            lines.append(f" {raw} = {slot.place.text(part.offset)}")
            scope[rest] = slot.convert.read
            texts[slot.name] = slot.convert.reading(raw, rest)
        if not texts and field.required:
            raise ConfigError(f"fingertip.dbc: no signal carries {schema.cls.__name__}.{field.name}")
        if not texts:
            scope[f"d{len(values)}"] = _default(schema.cls, field.name)
        values.append(signals.field_text(field, texts) if texts else f"d{len(values)}()")
    return [*lines, f" values = ({', '.join(values)},)"], scope


def _default(cls: type[Any], name: str) -> Any:
    declared = next(f for f in dataclasses.fields(cls) if f.name == name)
    if declared.default_factory is not dataclasses.MISSING:
        return declared.default_factory
    return lambda: declared.default


def _profile(message: DbcMessage) -> Profile:
    profile = _attributes(message)["E2EProfile"]
    name = profile.definition.choices[profile.value]
    if name not in CAN_PROFILES:
        raise ConfigError(f"fingertip.dbc: {message.name} has the E2E profile {name!r}")
    return CAN_PROFILES[name]


def _attribute(owner: Database | DbcMessage, name: str) -> Any:
    found = _attributes(owner).get(name)
    if found is None:
        raise ConfigError(f"fingertip.dbc: the attribute {name} is missing")
    return found.value


def _attributes(owner: Database | DbcMessage) -> Mapping[str, Any]:
    if owner.dbc is None:
        raise ConfigError("fingertip.dbc carries no attributes")
    return owner.dbc.attributes
