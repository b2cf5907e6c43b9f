"""Messages <-> msgpack payloads on topics, as ``proto/messages.toml`` declares them.

A payload is the 12-byte header of AUTOSAR E2E profile 4 (length, counter, Data ID, CRC-32) and one msgpack
map from field names to values, with the version of the message set under ``version``. Without this package
it reads as ``msgpack.unpackb(payload[12:])``.
"""

from collections import Counter
from collections.abc import Mapping
from collections.abc import Sequence as Names
from typing import Any, Final

import msgpack

from vegrip.messages import FingertipState, Message, make_row
from vegrip.transport.codec.fields import Fields
from vegrip.transport.codec.packing import MSGPACK_LIMITS, SEQUENCE_MODULUS, RefusedError
from vegrip.transport.codec.protection import P04, P04_COUNTER, P04_HEADER, P04_LIMIT
from vegrip.transport.codec.schema import message_set
from vegrip.transport.codec.streams import Streams
from vegrip.transport.codec.topics import ROUTES, Route, Topics

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

    Raises:
        ConfigError: a namespace or a finger's name that cannot stand in a topic.

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
        """Messages that never arrived, over all streams."""
        return self._streams.lost

    @property
    def crowded(self) -> int:
        """How many streams were forgotten to make room for others."""
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

    def reset(self) -> None:
        """Forget all counters: what comes next begins new streams (a replay that starts over)."""
        self._streams.reset()

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
