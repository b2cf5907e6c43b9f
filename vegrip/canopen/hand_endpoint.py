"""The fingers of a hand as CANopen devices: states out, on their own or with each SYNC; commands in."""

from collections.abc import Mapping, Sequence
from typing import Any

import can

from vegrip.canopen import network
from vegrip.canopen.device import Device
from vegrip.canopen.endpoint import CanopenEndpoint
from vegrip.canopen.grasp_endpoint import GraspEndpoint
from vegrip.canopen.network import claim
from vegrip.clock import NS
from vegrip.config import build
from vegrip.errors import ConfigError, VegripError
from vegrip.messages import FingertipState, Message
from vegrip.transport.can_endpoint import Open
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec import CanCodec
from vegrip.transport.open import CanSettings, Hand, open_bus

SYNCHRONOUS = 240  # transmission types up to this wait for SYNC
BY_ITSELF = 255  # one that does not


class HandEndpoint(CanopenEndpoint):
    """Every finger is a node of its own: it boots, is started, and sends."""

    def __init__(
        self,
        bus: can.BusABC,
        codec: CanCodec,
        settings: network.CanopenSettings,
        fingers: Sequence[int],
        hand: int = 0,
        reopen: Open | None = None,
        timing: BitTiming | None = None,
    ) -> None:
        super().__init__(
            bus, codec, network.identifiers(tuple(fingers), settings.node_id, hand), reopen, timing
        )
        self.devices = {
            node: Device(node, network.read_eds(settings.eds, node, "fingertip.eds"), self.network)
            for node in fingers
        }
        for device in self.devices.values():
            device.store(0x1017, 0, round(settings.heartbeat * 1000).to_bytes(2, "little"))
        self._by_name = dict(zip(codec.fingers, self.devices.values(), strict=True))
        self._waiting: dict[str, FingertipState] = {}  # for the next SYNC
        self._syncs = 0
        self.network.subscribe(network.SYNC, self._on_sync)

    def claim(self) -> None:
        claim(tuple(self.devices), self.put, self.can.next_frame, self.now)
        for device in self.devices.values():
            device.boot()

    def serve(self, now: int) -> None:
        for device in self.devices.values():
            device.serve(now / NS)
        self.network.serve(now)

    def send(self, message: Message) -> None:
        """Send a state at once, or with the next SYNC if the finger is configured so; the newest counts."""
        if isinstance(message, FingertipState) and self._every(message.finger):
            self._waiting[message.finger] = message
        else:
            super().send(message)

    def accepts(self, cob_id: int) -> bool:
        device = self.devices.get(cob_id & 0x7F)
        return cob_id & 0x780 not in network.STATE_COB_IDS and device is not None and device.is_operational

    def speaks(self, cob_id: int) -> bool:
        device = self.devices.get(cob_id & 0x7F)
        return cob_id & 0x780 in network.STATE_COB_IDS and device is not None and device.is_operational

    def close(self) -> None:
        for node in self.devices:
            self.put(0x700 + node, bytes([network.STOPPED]))
        super().close()

    def _every(self, finger: str) -> int:
        """Return how many SYNCs make one state; 0: none, it is sent by itself."""
        device = self._by_name.get(finger)
        kind = device.number(0x1800, 2) if device is not None else BY_ITSELF
        return max(kind, 1) if kind <= SYNCHRONOUS else 0  # 0: with the next one, if there is a new state

    def _on_sync(self, _: int, __: bytes, ___: float) -> None:
        self._syncs += 1
        for finger in tuple(self._waiting):
            every = self._every(finger)
            if not every or self._syncs % every == 0:
                super().send(self._waiting.pop(finger))


def open_canopen(table: Mapping[str, Any], hand: Hand, where: str) -> CanopenEndpoint:
    settings = build(network.CanopenSettings, table, where)
    fingers = network.finger_nodes(settings.first_finger, hand.number, len(hand.fingers))
    if settings.node_id in fingers:
        raise ConfigError(f"{where}: 'node_id' {settings.node_id} is that of a finger; choose another")
    own = "fingertip.eds" if settings.role == "hand" else "grasp_force.eds"
    network.read_eds(settings.eds, settings.node_id, own)  # complains before the bus is opened
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
            received = network.identifiers(fingers, settings.node_id, hand.number)
            return CanopenEndpoint(bus, codec, received, reopen, timing)
        kind = HandEndpoint if settings.role == "hand" else GraspEndpoint
        made = kind(bus, codec, settings, fingers, hand.number, reopen, timing)
        made.claim()
    except VegripError:
        bus.shutdown()
        raise
    return made
