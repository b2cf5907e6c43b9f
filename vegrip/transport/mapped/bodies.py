"""What a message of a network is made of, by its format: loaded, read by paths, put together, dumped."""

import json
from collections.abc import Callable
from typing import Any, Final, Protocol

import msgpack

from vegrip.transport.codec.packing import MSGPACK_LIMITS
from vegrip.transport.mapped.paths import Step, getter, put
from vegrip.transport.mapped.plan import Plan

WIDER: Final = {**MSGPACK_LIMITS, "max_array_len": 1024, "max_map_len": 1024}

Steps = tuple[Step, ...]


class Bodies(Protocol):
    """All messages of one hand."""

    def load(self, topic: str, payload: bytes) -> Any:
        """Return the message that came on ``topic``.

        Raises:
            ValueError: it is none.

        """

    def getter(self, topic: str, steps: Steps, where: str) -> Callable[[Any], Any]:
        """Return the function that takes a value out of a message; None where it is not there.

        Raises:
            ConfigError: the messages of ``topic`` have no such place.

        """

    def check(self, topic: str, steps: Steps, where: str) -> None:
        """Look whether a number can be put there; raises as :meth:`getter` does."""

    def put(self, topic: str, body: Any, steps: Steps, value: float) -> Any:
        """Return ``body`` (None: a new message) with ``value`` at ``steps``."""

    def dump(self, body: Any) -> bytes:
        """Return the payload."""


class PlainBodies:
    """JSON or msgpack: dictionaries and lists."""

    def __init__(self, *, is_json: bool) -> None:
        self._json = is_json

    def load(self, topic: str, payload: bytes) -> Any:  # noqa: ARG002 (all topics alike)
        """Return a dictionary or a list."""
        try:
            body = json.loads(payload) if self._json else msgpack.unpackb(payload, **WIDER)
        except (RecursionError, msgpack.UnpackException) as error:
            raise ValueError(str(error)) from None
        if not isinstance(body, (dict, list)):
            raise ValueError("neither a dictionary nor a list")
        return body

    def getter(self, topic: str, steps: Steps, where: str) -> Callable[[Any], Any]:  # noqa: ARG002
        """Return the function that follows ``steps``."""
        return getter(steps)

    def check(self, topic: str, steps: Steps, where: str) -> None:
        """Take every place: what is missing is made."""

    def put(self, topic: str, body: Any, steps: Steps, value: float) -> Any:  # noqa: ARG002
        """Return ``body`` with ``value``."""
        return put(body, steps, value)

    def dump(self, body: Any) -> bytes:
        """Return the payload."""
        return json.dumps(body).encode() if self._json else bytes(msgpack.packb(body))


def bodies_of(plan: Plan) -> Bodies:
    """Return the messages of the hand of ``plan``.

    Raises:
        ConfigError: protobuf without its library, its descriptors, or the type of a topic.

    """
    if plan.hand.format != "protobuf":
        return PlainBodies(is_json=plan.hand.format == "json")
    from vegrip.transport.mapped.protobuf import ProtobufBodies  # noqa: PLC0415 (an optional library)

    types = {topic: spec.type for topic, spec in plan.hand.messages.items()}
    return ProtobufBodies(plan.database.descriptors, types, str(plan.hand.database))
