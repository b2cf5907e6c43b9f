"""All fields of one kind of message <-> one msgpack map."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

from vegrip.messages import Message
from vegrip.transport.codec.packing import RefusedError, checked_time, packer, unpacker
from vegrip.transport.codec.schema import MessageSchema


class Fields:
    """The fields of one kind of message, ready to pack and unpack."""

    def __init__(self, schema: MessageSchema) -> None:
        self._owner = schema.owner
        self._pack = [(f.name, f.required, packer(f)) for f in schema.fields]
        self._unpack = [(f.name, f.required, unpacker(f)) for f in schema.fields]

    def owner_of(self, message: Message) -> str:
        """Return the name of the finger or node."""
        return str(getattr(message, self._owner))

    def pack(self, message: Message, version: int, clipped: Counter[str]) -> dict[str, Any] | None:
        """Return the map to send, None when a required field cannot be carried."""
        body: dict[str, Any] = {"version": version}
        for name, required, pack in self._pack:
            try:
                item = pack(getattr(message, name))
            except RefusedError:
                clipped[name] += 1
                if required:
                    return None
                continue
            if item is not None:
                body[name] = item
        return body

    def unpack(self, body: Mapping[str, Any]) -> dict[str, Any]:
        """Return the arguments of the message; fields of later versions are passed over."""
        values = {}
        for name, required, unpack in self._unpack:
            if name in body:
                values[name] = unpack(body[name])
            elif required:
                raise RefusedError("schema")
        return values


def restamp(schema: MessageSchema, values: dict[str, Any], stamp: int) -> None:
    """Set the stamp to ``stamp`` [ns] and move all other times by as much, if they stay times."""
    shift = stamp - values["stamp"]
    for field in schema.fields:
        if field.kind == "time":
            values[field.name] = checked_time(values[field.name] + shift)
