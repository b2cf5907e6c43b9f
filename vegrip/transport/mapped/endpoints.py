"""Open the hand that a map describes, on CAN or on ZeroMQ."""

from pathlib import Path
from typing import Any

from vegrip.errors import ConfigError
from vegrip.transport.curve import Keys
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.endpoint import MappedCanEndpoint
from vegrip.transport.mapped.open import open_plan
from vegrip.transport.mapped.price import settings
from vegrip.transport.mapped.topics import TopicCodec
from vegrip.transport.mapped.zmq import MappedZmqEndpoint
from vegrip.transport.open import CanSettings, Hand, ZmqSettings, open_bus


def open_mapped_can(table: CanSettings, hand: Hand) -> Endpoint:
    """Open a hand of another make on a CAN bus.

    Raises:
        ConfigError: its map cannot be used.
        DeviceError: the bus cannot be opened.

    """
    plan = open_plan(table.map, hand.fingers)
    if plan.hand.format:
        raise ConfigError(f"{table.map}: is for ZeroMQ; on CAN a map has a database = '...'")
    codec = MappedCodec(plan)
    bus, again, timing = open_bus(table)
    return MappedCanEndpoint(bus, codec, again, timing)


def open_mapped_zmq(table: ZmqSettings, hand: Hand, keys: Keys | None) -> Endpoint:
    """Open a hand of another make on a network.

    Raises:
        ConfigError: its map, or an address, cannot be used.
        DeviceError: an address is in use.

    """
    plan = open_plan(table.map, hand.fingers)
    if not plan.hand.format:
        raise ConfigError(
            f"{table.map}: is for CAN; over ZeroMQ a map has format = 'json', 'msgpack' or 'protobuf'"
        )
    return MappedZmqEndpoint(table.publish, table.subscribe, TopicCodec(plan), keys)


def settings_of(path: Path) -> dict[str, Any]:
    """Return the parameters of the grip controller that follow from the map at ``path``.

    Raises:
        ConfigError: the map cannot be used.

    """
    return settings(open_plan(path))
