"""From ``proto/fingertip.dbc`` to layouts, by way of cantools."""

import dataclasses
from collections.abc import Callable, Mapping
from functools import cache
from math import gcd
from typing import Any

import cantools
from cantools.database.can import Database
from cantools.database.can import Message as DbcMessage

from vegrip.errors import ConfigError
from vegrip.transport.codec.cells import Place, plan
from vegrip.transport.codec.convert import Converter
from vegrip.transport.codec.layout import Layout, Layouts, Part, Slot
from vegrip.transport.codec.members import Read, attribute, belongs, converter, getter, reader, row_reader
from vegrip.transport.codec.protection import CAN_PROFILES, COUNTER_MODULUS, Profile
from vegrip.transport.codec.schema import Field, MessageSchema, message_set, read_proto

HEADER = ("crc", "counter", "seq", "version", "last", "time")


@cache
def database() -> Database:
    """Read ``fingertip.dbc`` with cantools (once)."""
    loaded = cantools.database.load_string(read_proto("fingertip.dbc"), database_format="dbc")
    if not isinstance(loaded, Database):
        raise ConfigError("fingertip.dbc is not a CAN database")
    return loaded


@cache
def layouts() -> Layouts:
    """Return the layouts of ``fingertip.dbc``, compiled (once)."""
    return build_layouts(database())


def build_layouts(db: Database) -> Layouts:
    """Compile all messages of ``db``.

    Identifiers come in blocks of one size, which the base identifiers are multiples of.

    Raises:
        ConfigError: a signal that no field owns, a field's type that a signal cannot carry, another version.

    """
    version, hand, finger = (
        _attribute(db, key) for key in ("MessageSetVersion", "HandStride", "FingerStride")
    )
    if version != message_set().version:
        raise ConfigError(f"fingertip.dbc has version {version}, messages.toml {message_set().version}")
    block = gcd(*(message.frame_id for message in db.messages))
    compiled = tuple(
        _layout(schema, fd, [m for m in db.messages if m.is_fd == fd and _kind(m) == schema.cls.__name__])
        for schema in message_set().messages.values()
        if schema.on_can
        for fd in (False, True)
    )
    return Layouts(version, hand, finger, block // hand, hand // finger, compiled)


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
    fields = [f for f in schema.fields if f.name not in ("stamp", schema.owner, "seq")]
    rows = row_reader([_reader(schema, field, parts) for field in fields])
    relative = tuple(i for i, field in enumerate(fields) if field.kind == "time")
    return Layout(schema, fd, tuple(parts), rows, relative)


def _part(schema: MessageSchema, message: DbcMessage, offset: int) -> Part:
    packer, places = plan(message)
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
    schema: MessageSchema, message: DbcMessage, name: str, names: tuple[str, ...], place: Place
) -> Slot:
    field = next((f for f in schema.fields if belongs(f, name)), None)
    if field is None:
        raise ConfigError(
            f"fingertip.dbc: {message.name}.{name} belongs to no field of {schema.cls.__name__}"
        )
    signal = message.get_signal_by_name(name)
    return Slot(
        name, field, attribute(field, name), getter(field, name, names), converter(field, signal), place
    )


def _reader(
    schema: MessageSchema, field: Field, parts: list[Part]
) -> tuple[Read, Place | None, Converter | None]:
    """Return what makes a field; of one signal with a number, also its place and converter."""
    found = {
        slot.name: (dataclasses.replace(slot.place, cell=slot.place.cell + part.offset), slot.convert)
        for part in parts
        for slot in part.slots
        if slot.field is field
    }
    if found:
        is_number = field.kind == "float"
        place, convert = found[field.name] if is_number else (None, None)
        return reader(field, found), place, convert
    if field.required:
        raise ConfigError(f"fingertip.dbc: no signal carries {schema.cls.__name__}.{field.name}")
    default = _default(schema.cls, field.name)
    return lambda _: default(), None, None


def _default(cls: type[Any], name: str) -> Callable[[], Any]:
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


def _kind(message: DbcMessage) -> str:
    return str(_attribute(message, "MessageName"))


def _attribute(owner: Database | DbcMessage, name: str) -> Any:
    found = _attributes(owner).get(name)
    if found is None:
        raise ConfigError(f"fingertip.dbc: the attribute {name} is missing")
    return found.value


def _attributes(owner: Database | DbcMessage) -> Mapping[str, Any]:
    if owner.dbc is None:
        raise ConfigError("fingertip.dbc carries no attributes")
    return owner.dbc.attributes
