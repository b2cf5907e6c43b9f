"""Make an endpoint from a ``[transport]`` table with ``kind = "canopen"``."""

from collections.abc import Mapping
from typing import Any

from vegrip.canopen.connection_set import CanopenSettings, finger_nodes, identifiers
from vegrip.canopen.eds import read_eds
from vegrip.canopen.endpoint import CanopenEndpoint
from vegrip.canopen.grasp_endpoint import GraspEndpoint
from vegrip.canopen.hand_endpoint import HandEndpoint
from vegrip.config import build
from vegrip.errors import ConfigError, VegripError
from vegrip.transport.codec import CanCodec
from vegrip.transport.open import CanSettings, Hand, open_bus


def open_canopen(table: Mapping[str, Any], hand: Hand, where: str) -> CanopenEndpoint:
    """Open what ``table`` describes.

    Raises:
        ConfigError: the table or an EDS file cannot be used.
        DeviceError: the bus cannot be opened, or a node-ID is taken.

    """
    settings = build(CanopenSettings, table, where)
    fingers = finger_nodes(settings.first_finger, hand.number, len(hand.fingers))
    if settings.node_id in fingers:
        raise ConfigError(f"{where}: 'node_id' {settings.node_id} is that of a finger; choose another")
    own = "fingertip.eds" if settings.role == "hand" else "grasp_force.eds"
    read_eds(settings.eds, settings.node_id, own)  # complains before the bus is opened
    raw = CanSettings(
        interface=settings.interface,
        channel=settings.channel,
        fd=False,
        bitrate=settings.bitrate,
        options=settings.options,
    )
    bus, reopen, timing = open_bus(raw)
    codec = CanCodec(hand.fingers, fd=False, hand=hand.number)
    try:
        if settings.role == "listen":
            heard = identifiers(fingers, settings.node_id, hand.number)
            return CanopenEndpoint(bus, codec, heard, reopen, timing)
        kind = HandEndpoint if settings.role == "hand" else GraspEndpoint
        made = kind(bus, codec, settings, fingers, hand.number, reopen, timing)
        made.claim()
    except VegripError:
        bus.shutdown()
        raise
    return made
