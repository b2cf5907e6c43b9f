"""All fields of one kind of message <-> one msgpack map."""

import dataclasses
import math
from collections import Counter
from collections.abc import Mapping
from itertools import takewhile
from typing import Any, Final

from vegrip.messages import Message
from vegrip.transport.codec.packing import RefusedError, checked_time, packer, unpacker
from vegrip.transport.codec.schema import Field, MessageSchema

FLOATS: Final = {float}
INFINITIES: Final = frozenset({math.inf, -math.inf})


class Fields:
    """The fields of one kind of message, ready to pack and unpack: first stamp, owner and number."""

    def __init__(self, schema: MessageSchema) -> None:
        self._owner = schema.owner
        self._pack = [(f.name, f.required, f.kind == "float", packer(f)) for f in schema.fields]
        unpack = [(f.name, _default(schema, f), unpacker(f)) for f in schema.fields]
        quantities = len(list(takewhile(_may_be_missing, reversed(schema.fields))))
        self._head, self._quantities = unpack[: len(unpack) - quantities], unpack[len(unpack) - quantities :]
        self._names = [name for name, _, _ in self._quantities]
        self._missing = [math.nan] * quantities
        self._times = [i for i, f in enumerate(schema.fields) if f.kind == "time"]

    def owner_of(self, message: Message) -> str:
        """Return the name of the finger or node."""
        return str(getattr(message, self._owner))

    def pack(self, message: Message, version: int, clipped: Counter[str]) -> dict[str, Any] | None:
        """Return the map to send, None when a required field cannot be carried."""
        body: dict[str, Any] = {"version": version}
        for name, required, is_quantity, pack in self._pack:
            item = getattr(message, name)
            if is_quantity and type(item) is float and item - item == 0.0:
                body[name] = item  # what most are; the call takes longer than the rest
                continue
            try:
                item = pack(item)
            except RefusedError:
                clipped[name] += 1
                if required:
                    return None
                continue
            if item is not None:
                body[name] = item
        return body

    def unpack(self, body: Mapping[str, Any]) -> list[Any]:
        """Return the values of the fields in their order; fields of later versions are passed over."""
        row = [_value(body, *one) for one in self._head]
        measured = list(map(body.get, self._names, self._missing))
        if set(map(type, measured)) <= FLOATS and INFINITIES.isdisjoint(measured):
            return row + measured  # one by one they take twice as long
        return row + [_value(body, *one) for one in self._quantities]

    def restamp(self, row: list[Any], stamp: int) -> None:
        """Set the stamp of the values to ``stamp`` [ns] and move all other times by as much."""
        shift = stamp - row[0]
        for i in self._times:
            row[i] = checked_time(row[i] + shift)


def _value(body: Mapping[str, Any], name: str, default: Any, unpack: Any) -> Any:
    if name in body:
        return unpack(body[name])
    if default is dataclasses.MISSING:
        raise RefusedError("schema")
    return default


def _default(schema: MessageSchema, field: Field) -> Any:
    """Return the value of a field that is not sent."""
    declared = schema.cls.__dataclass_fields__[field.name]
    made = declared.default_factory
    return declared.default if field.required or made is dataclasses.MISSING else made()


def _may_be_missing(field: Field) -> bool:
    return field.kind == "float" and not (field.required or field.infinite)
