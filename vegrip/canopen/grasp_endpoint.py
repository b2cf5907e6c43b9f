"""The grasp force node as a CANopen device: its NMT state, its parameters by SDO, its fingers watched."""

import logging
from collections.abc import Mapping, Sequence
from typing import Any

import can
from canopen.objectdictionary import ODVariable
from canopen.sdo import SdoAbortedError

from vegrip.canopen import network
from vegrip.canopen.device import HEARTBEAT_LOST, ID_TAKEN, NOT_ITS_EDS, SOFTWARE, Device
from vegrip.canopen.endpoint import CanopenEndpoint
from vegrip.canopen.network import claim
from vegrip.canopen.sensors import Sensors
from vegrip.clock import NS
from vegrip.errors import VegripError
from vegrip.messages import ContactEstimate, Lifecycle, Message
from vegrip.runtime.handle import NodeHandle
from vegrip.transport.can_endpoint import Open
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec import CanCodec, Frame

REFUSED = 0x06090030  # value range of parameter exceeded
NOT_NOW = 0x08000022  # not because of the present device state
NOT_THERE = 0x060A0023  # resource not available
LONGEST_REASON = 120  # [characters] at 2400h


class SdoParameters:
    """Serves objects from 3000h on. Object 2400h says in one sentence why the last write was refused."""

    def __init__(self, device: Device, node: NodeHandle) -> None:
        self._device = device
        self._node = node
        device.local.add_read_callback(self._read)
        device.local.add_write_callback(self._write)

    def _read(self, index: int, subindex: int, od: ODVariable) -> Any:  # noqa: ARG002 (called by name)
        if index < network.PARAMETERS or index >= 0x6000:
            return None
        values = self._node.parameters()
        if od.name not in values:
            raise SdoAbortedError(NOT_THERE)
        return values[od.name]

    def _write(self, index: int, subindex: int, od: ODVariable, data: bytes) -> None:  # noqa: ARG002
        if index < network.PARAMETERS or index >= 0x6000:
            return
        try:
            self._node.set_parameter(od.name, od.decode_raw(bytes(data)))
        except VegripError as error:
            reason = str(error).encode("ascii", "replace")[:LONGEST_REASON]
            self._device.store(network.REFUSAL, 0, reason)
            raise SdoAbortedError(NOT_NOW if "cannot be changed now" in str(error) else REFUSED) from None


RECORDS: Mapping[int, str] = {
    network.COMMANDS: "ForceCommand",
    network.MARGINS: "SlipMargin",
    network.HEALTH: "ModelHealth",
}


class Mirror:
    """Answers reads of the mapped objects of the grasp force node, and of its estimates."""

    def __init__(self, device: Device, fingers: Sequence[str], hand: int) -> None:
        self._frames: dict[int, bytes] = {}  # identifier of the classic frame -> data
        self._estimates: dict[str, ContactEstimate] = {}
        self._fingers = list(fingers)
        self._device = device
        self._identifiers = {
            record + number: network.frame_base(name) + 8 * hand + number
            for record, name in RECORDS.items()
            for number in range(len(fingers))
        } | {network.STATUS: network.frame_base("NodeStatus") + 8 * hand}
        device.local.add_read_callback(self._read)

    def keep(self, message: Message | None, frames: Sequence[Frame]) -> None:
        """Remember what is sent: frames, and the message that they carry where it is known."""
        if isinstance(message, ContactEstimate):
            self._estimates[message.finger] = message
        for frame in frames:
            self._frames[frame.arbitration_id] = frame.data

    def _read(self, index: int, subindex: int, od: ODVariable) -> Any:
        if index in self._identifiers and subindex:
            return self._part(self._frames.get(self._identifiers[index]), index, subindex, len(od) // 8)
        if subindex and 0 <= index - network.ESTIMATES < len(self._fingers):
            return self._estimate(self._fingers[index - network.ESTIMATES], subindex)
        return None

    def _part(self, data: bytes | None, index: int, subindex: int, size: int) -> bytes | None:
        if data is None:
            return None
        record = self._device.local.object_dictionary[index]
        start = sum(len(record[sub]) // 8 for sub in range(1, subindex))
        return data[start : start + size]

    def _estimate(self, finger: str, subindex: int) -> float:
        which, is_std = divmod(subindex - 1, 2)
        message = self._estimates.get(finger)
        estimate = getattr(message, network.ESTIMATED[which]) if message is not None else None
        if estimate is None:
            return float("nan")
        return float(estimate.std if is_std else estimate.value)


IS_IT = "is it connected, switched on, and at the same bit rate (transport.bitrate)?"
LOOK_PERIOD_NS = (
    10_000_000  # [ns] between two looks at the fingers; what it finds is reported with the next heartbeat
)
ON_ERROR = {0: Lifecycle.INACTIVE, 2: Lifecycle.UNCONFIGURED}  # object 1029sub1; 1: go on
FAULT_NAMES = {
    HEARTBEAT_LOST: "heartbeat_lost",
    NOT_ITS_EDS: "not_its_eds",
    ID_TAKEN: "id_taken",
    SOFTWARE: "refused",
}


class GraspEndpoint(CanopenEndpoint):
    """One end of the bus: receives states, sends commands."""

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
        node = settings.node_id
        super().__init__(bus, codec, network.identifiers(tuple(fingers), node, hand), reopen, timing)
        own = network.read_eds(settings.eds, node, "grasp_force.eds")
        self.device = Device(node, own, self.network, self._command)
        self.sensors = Sensors(
            fingers,
            network.read_eds(settings.finger_eds, fingers[0], "fingertip.eds"),
            round(settings.heartbeat_limit * NS),
            round(settings.first_heartbeat * NS),
            self.put,
            self.now(),
            is_master=settings.master,
        )
        self._settings = settings
        self._names = dict(zip(fingers, codec.fingers, strict=True))
        self._mirror = Mirror(self.device, codec.fingers, hand)
        self._look_at = 0  # [ns]
        self._node: NodeHandle | None = None
        self._autostart = self._start_pending = False
        self._logger = logging.getLogger("vegrip.canopen")
        self._describe(fingers)

    def claim(self) -> None:
        claim((self.device.id,), self.put, self.can.next_frame, self.now)

    def supervise(self, node: NodeHandle, *, autostart: bool) -> None:
        """Appear on the bus; activate the node once every finger is there, right and sending."""
        self._node = node
        self._autostart = self._start_pending = autostart
        SdoParameters(self.device, node)
        waited_for = ", ".join(f"{name} (node {finger})" for finger, name in self._names.items())
        self._logger.info("waits for %s", waited_for)
        self._appear()
        if self._settings.sync_period > 0.0:
            self.network.send_periodic(network.SYNC, b"", self._settings.sync_period)
        if self._settings.time_period > 0.0:
            self.network.tasks.add(network.TimeProducer(self._settings.time_period, self.now(), self.network))

    def serve(self, now: int) -> None:
        """Send what is due; look after the fingers and our own state."""
        if self._node is None:
            return
        self.device.set_state(network.nmt_state(self._node.state, is_on_hold=self._node.on_hold))
        if now >= self._look_at:
            self._look_at = now + LOOK_PERIOD_NS
            self.device.serve(now / NS)
            self._judge(self.sensors.serve(now), self._node)
        self.network.serve(now)

    @property
    def due(self) -> int:
        return min(self.network.due, self._look_at)

    def service(self, frame: Frame) -> None:
        self.sensors.receive(frame.arbitration_id, frame.data, self.now())
        super().service(frame)

    def accepts(self, cob_id: int) -> bool:
        """States, of fingers that are what they should be, while we are operational."""
        sensor = self.sensors.all.get(cob_id & 0x7F)
        return (
            cob_id & 0x780 in network.STATE_COB_IDS
            and sensor is not None
            and sensor.is_verified
            and self.device.is_operational
        )

    def speaks(self, cob_id: int) -> bool:
        return self.device.is_operational and (
            cob_id & 0x7F == self.device.id or cob_id & 0x780 not in network.STATE_COB_IDS
        )

    def keep(self, message: Message | None, frames: list[Frame]) -> None:
        self._mirror.keep(message, frames)

    def close(self) -> None:
        if self._node is not None:
            self.device.set_state(network.STOPPED)
            self.put(0x700 + self.device.id, bytes([network.STOPPED]))
        super().close()

    def _describe(self, fingers: Sequence[int]) -> None:
        store, given = self.device.store, self._settings
        limit = round(given.heartbeat_limit * 1000)  # [ms]
        store(0x1017, 0, round(given.heartbeat * 1000).to_bytes(2, "little"))
        store(
            0x1012,
            0,
            (network.TIME_COB_ID | (network.PRODUCED if given.time_period else network.CONSUMED)).to_bytes(
                4, "little"
            ),
        )
        store(0x1006, 0, round(given.sync_period * 1e6).to_bytes(4, "little"))
        for number, finger in enumerate(fingers):
            store(0x1016, number + 1, (finger << 16 | limit).to_bytes(4, "little"))
            for part, base in enumerate((0x180, 0x280, 0x380)):
                store(0x1400 + 3 * number + part, 1, (base + finger).to_bytes(4, "little"))
            for kind, base in enumerate((0x200, 0x300, 0x400)):
                store(0x1800 + 8 * kind + number, 1, (0x4000_0000 + base + finger).to_bytes(4, "little"))

    def _appear(self) -> None:
        self.device.boot()
        for sensor in self.sensors.all.values():
            sensor.begin()

    def _command(self, command: int) -> None:
        targets = network.TRANSITIONS_OF_COMMAND.get(command)
        if targets is None or self._node is None:
            return
        self._start_pending = self._autostart and command in (network.RESET_NODE, network.RESET_COMMUNICATION)
        self._node.request(*targets, refused=self._refused)
        if command in (network.RESET_NODE, network.RESET_COMMUNICATION):
            self._appear()

    def _refused(self, sentence: str) -> None:
        self._begin(SOFTWARE, self.device.id, sentence)

    def _judge(self, missing: Sequence[int], node: NodeHandle) -> None:
        for finger in missing:
            name = self._names[finger]
            self._begin(HEARTBEAT_LOST, finger, f"no heartbeat from {name} (node {finger}); {IS_IT}")
            # what object 1029h says; by default the node goes on, with that finger held
            target = ON_ERROR.get(self.device.number(0x1029, 1))
            if target is not None and node.state is Lifecycle.ACTIVE:
                self._start_pending = False
                node.request(target, refused=self._refused)
        for finger, sensor in self.sensors.all.items():
            if sensor.difference:
                what = f"{self._names[finger]} (node {finger}) is not what fingertip.eds says: "
                remedy = "; connect the right device, or give its EDS (transport.finger_eds)"
                self._begin(NOT_ITS_EDS, finger, what + sensor.difference + remedy)
            elif sensor.is_verified:
                self._end(NOT_ITS_EDS, finger)
            if finger not in self.sensors.consumer.missing:
                self._end(HEARTBEAT_LOST, finger)
        if node.on_hold:
            self._begin(SOFTWARE, self.device.id, "the node has failed; its last safe commands are held")
        elif node.state is Lifecycle.ACTIVE:
            self._end(SOFTWARE, self.device.id)
        ready = self.sensors.is_ready and not self.device.emergencies.standing
        if self._start_pending and ready and self.device.state == network.PRE_OPERATIONAL:
            self._start_pending = False
            node.request(Lifecycle.ACTIVE, refused=self._refused)

    def _begin(self, code: int, about: int, sentence: str) -> None:
        state = self._node.state if self._node is not None else Lifecycle.UNCONFIGURED
        if self.device.emergencies.begin(code, about, sentence, state):
            self.faults[FAULT_NAMES[code]] += 1
            self._logger.error("%s", sentence)

    def _end(self, code: int, about: int) -> None:
        if self._node is not None and (code, about) in self.device.emergencies.standing:
            self.device.emergencies.end(code, about, self._node.state)
            self._logger.warning("over: EMCY %04Xh of node %d", code, about)
