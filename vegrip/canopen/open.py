"""Make an endpoint from a ``[transport]`` table with ``kind = "canopen"``."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import can

from vegrip.canopen.connection_set import FIRST_FINGER, GRASP_NODE_ID, finger_nodes, identifiers
from vegrip.canopen.eds import read_eds
from vegrip.canopen.endpoint import CanopenEndpoint
from vegrip.canopen.grasp_endpoint import GraspEndpoint
from vegrip.canopen.hand_endpoint import HandEndpoint
from vegrip.config import build, parameter
from vegrip.errors import ConfigError, VegripError
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec import CanCodec
from vegrip.transport.open import CanSettings, Hand, open_bus

MAX_NODE_ID = 127


@dataclass(frozen=True)
class CanopenSettings:
    """``[transport]`` with ``kind = "canopen"``."""

    kind: str = parameter("canopen")
    interface: str = parameter("vegrip", doc="python-can interface: vegrip, socketcan, virtual, slcan, ...")
    channel: str = parameter("vegrip0", doc="name of the bus or device")
    bitrate: int = parameter(1_000_000, unit="bit/s", low=10_000, high=1_000_000)
    options: dict[str, Any] = parameter({}, doc="anything else python-can's interface understands")
    role: str = parameter("grasp", choices=("grasp", "hand", "listen"), doc="which end of the bus this is")
    node_id: int = parameter(GRASP_NODE_ID, low=1, high=MAX_NODE_ID, doc="of the grasp force node")
    first_finger: int = parameter(FIRST_FINGER, low=1, high=MAX_NODE_ID, doc="node-ID of finger 0 of hand 0")
    eds: str = parameter("", doc="EDS file of this end; empty: that of vegrip")
    finger_eds: str = parameter("", doc="EDS file that the fingers must agree with; empty: that of vegrip")
    heartbeat: float = parameter(0.2, unit="s", low=0.01, high=60.0, doc="period of our own")
    heartbeat_limit: float = parameter(0.5, unit="s", low=0.02, high=60.0, doc="longest silence of a finger")
    first_heartbeat: float = parameter(
        10.0, unit="s", low=0.02, high=600.0, doc="time a finger may take to appear"
    )
    sync_period: float = parameter(0.0, unit="s", low=0.0, high=10.0, doc="of SYNC; 0: none is produced")
    time_period: float = parameter(0.0, unit="s", low=0.0, high=60.0, doc="of TIME; 0: none is produced")
    master: bool = parameter(True, doc="the grasp force node starts the fingers (NMT)")


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
    read_eds(settings.eds, settings.node_id, _file(settings.role))  # complains before the bus is opened
    raw = CanSettings(
        interface=settings.interface,
        channel=settings.channel,
        fd=False,
        bitrate=settings.bitrate,
        options=settings.options,
    )
    bus, reopen, timing = open_bus(raw)
    try:
        return _made(settings, hand, fingers, bus, reopen, timing)
    except VegripError:
        bus.shutdown()
        raise


def _file(role: str) -> str:
    return "fingertip.eds" if role == "hand" else "grasp_force.eds"


def _made(
    settings: CanopenSettings,
    hand: Hand,
    fingers: tuple[int, ...],
    bus: can.BusABC,
    reopen: Any,
    timing: BitTiming | None,
) -> CanopenEndpoint:
    codec = CanCodec(hand.fingers, fd=False, hand=hand.number)
    if settings.role == "listen":
        return CanopenEndpoint(
            bus, codec, identifiers(fingers, settings.node_id, hand.number), reopen, timing
        )
    if settings.role == "hand":
        fingertips = HandEndpoint(
            bus,
            codec,
            fingers=fingers,
            grasp=settings.node_id,
            eds=settings.eds,
            hand=hand.number,
            heartbeat=settings.heartbeat,
            reopen=reopen,
            timing=timing,
        )
        fingertips.claim()
        return fingertips
    grasp = GraspEndpoint(
        bus,
        codec,
        node=settings.node_id,
        dictionary=read_eds(settings.eds, settings.node_id, _file(settings.role)),
        fingers=fingers,
        finger_dictionary=read_eds(settings.finger_eds, fingers[0], "fingertip.eds"),
        hand=hand.number,
        heartbeat=settings.heartbeat,
        limit=settings.heartbeat_limit,
        first=settings.first_heartbeat,
        sync_period=settings.sync_period,
        time_period=settings.time_period,
        is_master=settings.master,
        reopen=reopen,
        timing=timing,
    )
    grasp.claim()
    return grasp
