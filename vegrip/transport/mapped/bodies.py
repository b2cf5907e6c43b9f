"""Bodies of messages on a network, read and filled by paths such as ``tips[name=thumb].fx``."""

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import msgpack

from vegrip.transport.codec.msgpack_codec import MSGPACK_LIMITS
from vegrip.transport.mapped.body_paths import Steps, getter, put
from vegrip.transport.mapped.plan import Plan

if TYPE_CHECKING:
    from vegrip.transport.mapped.protobuf import ProtobufBodies

Bodies: TypeAlias = "PlainBodies | ProtobufBodies"

WIDER: Final = {**MSGPACK_LIMITS, "max_array_len": 1024, "max_map_len": 1024}


class PlainBodies:
    """JSON or msgpack: dictionaries and lists."""

    def __init__(self, *, is_json: bool) -> None:
        self._json = is_json

    def load(self, topic: str, payload: bytes) -> Any:  # noqa: ARG002 (all topics alike)
        """Return the message that came on ``topic``."""
        try:
            body = json.loads(payload) if self._json else msgpack.unpackb(payload, **WIDER)
        except (RecursionError, msgpack.UnpackException) as error:
            raise ValueError(str(error)) from None
        if not isinstance(body, (dict, list)):
            raise ValueError("neither a dictionary nor a list")
        return body

    def getter(self, topic: str, steps: Steps, where: str) -> Callable[[Any], Any]:  # noqa: ARG002
        return getter(steps)

    def check(self, topic: str, steps: Steps, where: str) -> None:
        """Accept every place: :meth:`put` makes what is missing."""

    def put(self, topic: str, body: Any, steps: Steps, value: float) -> Any:  # noqa: ARG002
        """Return ``body`` (None: a new message) with ``value`` at ``steps``."""
        return put(body, steps, value)

    def dump(self, body: Any) -> bytes:
        return json.dumps(body).encode() if self._json else bytes(msgpack.packb(body))


def bodies_of(plan: Plan) -> Bodies:
    if plan.hand.format != "protobuf":
        return PlainBodies(is_json=plan.hand.format == "json")
    from vegrip.transport.mapped.protobuf import ProtobufBodies  # noqa: PLC0415 (an optional library)

    types = {topic: spec.type for topic, spec in plan.hand.messages.items()}
    return ProtobufBodies(plan.database.descriptors, types, str(plan.hand.file))
