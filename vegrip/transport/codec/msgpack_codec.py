"""Messages <-> msgpack payloads on topics, as ``proto/messages.toml`` declares them.

A payload is the 12-byte header of AUTOSAR E2E profile 4 (length, counter, Data ID, CRC-32) and one msgpack
map from field names to values, with the version of the message set under ``version``. Without this package
it reads as ``msgpack.unpackb(payload[12:])``.
"""

import dataclasses
import math
import re
from collections import Counter
from collections.abc import Callable, Mapping
from collections.abc import Sequence as Names
from functools import lru_cache
from itertools import takewhile
from typing import Any, Final

import msgpack

from vegrip.messages import Estimate, FingertipState, Message, make_row
from vegrip.transport.codec.protection import P04, P04_COUNTER, P04_HEADER, P04_LIMIT
from vegrip.transport.codec.schema import (
    ROUTES,
    Enumeration,
    Field,
    MessageSchema,
    Route,
    Topics,
    message_set,
)
from vegrip.transport.codec.sequence import Streams

TEXT_LIMIT: Final = 64  # characters
MAP_LIMIT: Final = 64  # entries
MSGPACK_LIMITS: Final = {
    "max_str_len": TEXT_LIMIT * 4,  # bytes
    "max_array_len": 8,
    "max_map_len": MAP_LIMIT,
    "max_bin_len": 0,
    "max_ext_len": 0,
}
SEQUENCE_MODULUS: Final = 1 << 32
INT64_MIN: Final = -(1 << 63)
INT64_MAX: Final = (1 << 63) - 1
NAME: Final = re.compile(r"[A-Za-z0-9_\-./]{1,64}")

Convert = Callable[[Any], Any]


class RefusedError(Exception):
    """Why a payload is no message; never leaves the codec."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


def packer(field: Field) -> Convert:
    """Return value -> msgpack object, None to leave the field out; RefusedError: it cannot be carried."""
    if field.enumeration is not None:
        return int
    if field.kind == "float":
        return lambda value: _pack_float(value, field)
    return _PACK[field.kind]


def unpacker(field: Field) -> Convert:
    """Return msgpack object -> value; anything else raises RefusedError."""
    enumeration = field.enumeration
    if enumeration is not None:
        return lambda item: _enumerated(item, enumeration)
    if field.kind == "float":
        return lambda item: _float(item, field)
    return _UNPACK[field.kind]


def _pack_float(value: float, field: Field) -> float | None:
    if math.isfinite(value) or (field.infinite and not math.isnan(value)):
        return float(value)
    if math.isnan(value) and not field.required:
        return None
    raise RefusedError("value")


def _pack_estimate(estimate: Estimate) -> list[float | bool]:
    if math.isinf(estimate.value):
        raise RefusedError("value")
    return [float(estimate.value), float(estimate.std), bool(estimate.valid), float(estimate.age)]


def _pack_counts(counts: Mapping[str, int]) -> dict[str, int]:
    return {name[:TEXT_LIMIT]: _integer(int(count)) for name, count in list(counts.items())[:MAP_LIMIT]}


def _integer(item: Any, high: int = INT64_MAX) -> int:
    if type(item) is not int:  # a bool is an int for isinstance
        raise RefusedError("type")
    if not 0 <= item <= high:
        raise RefusedError("value")
    return item


def checked_time(item: Any) -> int:
    """Return a time [ns] that is an int64; what else msgpack can carry would overflow in numpy later."""
    if type(item) is not int:
        raise RefusedError("type")
    if not INT64_MIN <= item <= INT64_MAX:
        raise RefusedError("value")
    return item


def _float(item: Any, field: Field) -> float:
    value = _number(item)
    if value - value == 0.0:
        return value
    if field.required or (math.isinf(value) and not field.infinite):
        raise RefusedError("value")
    return value


def _number(item: Any) -> float:
    if type(item) is float:
        return item
    if type(item) is int:  # other languages send whole numbers so
        return float(item)
    raise RefusedError("type")


def _flag(item: Any) -> bool:
    if type(item) is not bool:
        raise RefusedError("type")
    return item


def _text(item: Any) -> str:
    if type(item) is not str:
        raise RefusedError("type")
    if len(item) > TEXT_LIMIT:
        raise RefusedError("size")
    return item


def _name(item: Any) -> str:
    if not _is_name(_text(item)):
        raise RefusedError("value")
    return str(item)


@lru_cache(maxsize=256)
def _is_name(text: str) -> bool:
    return NAME.fullmatch(text) is not None


def _estimate(item: Any) -> Estimate:
    if type(item) is not list or len(item) != 4:
        raise RefusedError("type")
    value = _number(item[0])
    if math.isinf(value):
        raise RefusedError("value")
    return Estimate(value, _number(item[1]), _flag(item[2]), _number(item[3]))


def _counts(item: Any) -> dict[str, int]:
    if type(item) is not dict:
        raise RefusedError("type")
    return {_text(name): _integer(count) for name, count in item.items()}


def _enumerated(item: Any, enumeration: Enumeration) -> Any:
    try:
        return enumeration(_integer(item))
    except ValueError:
        raise RefusedError("value") from None


_PACK: Final[Mapping[str, Convert]] = {
    "time": lambda value: checked_time(int(value)),
    "sequence": lambda value: int(value) % SEQUENCE_MODULUS,
    "name": str,
    "flag": bool,
    "count": lambda value: _integer(int(value)),
    "text": lambda value: value[:TEXT_LIMIT],
    "estimate": _pack_estimate,
    "counts": _pack_counts,
}
_UNPACK: Final[Mapping[str, Convert]] = {
    "time": checked_time,
    "sequence": lambda item: _integer(item, SEQUENCE_MODULUS - 1),
    "name": _name,
    "flag": _flag,
    "count": _integer,
    "text": _text,
    "estimate": _estimate,
    "counts": _counts,
}


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
    declared = schema.cls.__dataclass_fields__[field.name]
    made = declared.default_factory
    return declared.default if field.required or made is dataclasses.MISSING else made()


def _may_be_missing(field: Field) -> bool:
    return field.kind == "float" and not (field.required or field.infinite)


WHOLE: Final = frozenset({"unknown_topic", "counter"})
"""Why a message is refused that is not broken."""


class MsgpackCodec:
    """One hand on a network of topics.

    Nothing that comes from the network raises: :meth:`decode` returns None and counts in ``rejected`` under

    =================  ==================================================================================
    ``unknown_topic``  not a topic of this namespace, or of a finger that is not configured
    ``size``           longer than 4096 bytes, shorter than its header, or a text or map beyond its limit
    ``checksum``       the E2E checksum, length or Data ID fails
    ``schema``         not a msgpack map, or a required field is missing
    ``version``        another version of the message set
    ``type``           a field of another type
    ``value``          infinite where that is no value, unknown member of an enumeration, ...
    ``finger``         the finger in the message is not the one of the topic
    ``counter``        a repeat, older than the last one, or too far ahead of it
    =================  ==================================================================================

    ``lost`` counts messages that never arrived, ``clipped`` (by field) values that could not be sent,
    ``crowded`` the streams that were forgotten to make room for others, and ``broken`` by finger the states
    on its topic that could not be understood (of ``ROUTES`` fingers at most, where any name is accepted).

    Args:
        namespace: in front of every topic; one for each hand on the network.
        fingers: names of the fingers, None accepts any.
        remap: full topics of this program -> full topics on the wire.
        use_sender_time: keep the sender's stamps, right on one machine or with synchronised clocks. Otherwise
            the receive time is the stamp, and times that follow it (``expires``) move with it.

    """

    def __init__(
        self,
        namespace: str = "",
        fingers: Names[str] | None = None,
        *,
        remap: Mapping[str, str] | None = None,
        use_sender_time: bool = True,
    ) -> None:
        self.topics = Topics(namespace, fingers, remap)
        self.rejected: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.clipped: Counter[str] = Counter()
        self._use_sender_time = use_sender_time
        self._version = message_set().version
        self._packed = msgpack.Packer().pack
        self._fields = {s.cls: Fields(s) for s in message_set().messages.values()}
        self._streams = Streams(frozenset(fingers or ()), SEQUENCE_MODULUS)

    @property
    def lost(self) -> int:
        return self._streams.lost

    @property
    def crowded(self) -> int:
        return self._streams.crowded

    def encode(self, message: Message) -> tuple[str, bytes] | None:
        """Return topic and payload, None for a message that cannot be sent (counted in ``clipped``).

        That is a finger that is not configured, a force command that is not finite, and a NodeStatus with
        so many names of failures that it exceeds 4096 bytes.
        """
        fields = self._fields[type(message)]
        route = self.topics.outgoing(type(message), fields.owner_of(message))
        if route is None:
            self.clipped["finger"] += 1
            return None
        body = fields.pack(message, self._version, self.clipped)
        if body is None:
            return None
        data = bytearray(P04_HEADER)
        data += self._packed(body)
        if len(data) > P04_LIMIT:
            self.clipped["size"] += 1
            return None
        data[P04_COUNTER] = (message.seq & 0xFFFF).to_bytes(2, "big")
        P04.protect(data, route.data_id)
        return route.topic, bytes(data)

    def decode(self, topic: str, payload: bytes, stamp: int) -> Message | None:
        """Return the message in ``payload``, received at ``stamp`` [ns], None when there is none."""
        try:
            return self._decode(topic, payload, stamp)
        except RefusedError as refused:
            self.rejected[refused.name] += 1
            self._note_broken(topic, refused.name)
            return None

    def _note_broken(self, topic: str, why: str) -> None:
        route = None if why in WHOLE else self.topics.incoming(topic)
        if route is None or route.owner is None or route.schema.cls is not FingertipState:
            return
        if route.owner in self.broken or len(self.broken) < ROUTES:
            self.broken[route.owner] += 1

    def _decode(self, topic: str, payload: bytes, stamp: int) -> Message:
        route = self.topics.incoming(topic)
        if route is None:
            raise RefusedError("unknown_topic")
        body = self._body(payload, route)
        fields = self._fields[route.schema.cls]
        row = fields.unpack(body)
        _, owner, seq, *_ = row
        if route.owner not in (None, owner):
            raise RefusedError("finger")
        if int.from_bytes(payload[P04_COUNTER], "big") != seq & 0xFFFF:
            raise RefusedError("counter")
        row[2] = self._streams.of(topic, owner).advance(seq, stamp)
        if row[2] is None:
            raise RefusedError("counter")
        if not self._use_sender_time:
            fields.restamp(row, stamp)
        cls: Any = route.schema.cls
        message: Message = make_row(cls, row) if issubclass(cls, tuple) else cls(*row)
        return message

    def _body(self, payload: bytes, route: Route) -> dict[str, Any]:
        if not P04_HEADER < len(payload) <= P04_LIMIT:
            raise RefusedError("size")
        if not P04.check(payload, route.data_id):
            raise RefusedError("checksum")
        try:
            body = msgpack.unpackb(payload[P04_HEADER:], **MSGPACK_LIMITS)
        except (ValueError, msgpack.UnpackException):
            raise RefusedError("schema") from None
        if type(body) is not dict:
            raise RefusedError("schema")
        if body.get("version") != self._version:
            raise RefusedError("version")
        return body
