"""The package ``canopen`` served from a loop, which itself sends periodic messages when they are due.

A heartbeat that a thread or the kernel keeps sending says nothing about the loop; this one stops with it.

Which COB-ID carries what is the predefined connection set of CiA 301, seen from the fingers. A finger is one
node, sensor and drive: its TPDOs are its state, its RPDOs what the grasp force node commands. So a finger
needs no configuration, and the grasp force node sends on the RPDO identifiers of the fingers.
"""

import configparser
import logging
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any, Final

import canopen
import canopen.network
from canopen.objectdictionary import ObjectDictionary, ODVariable

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.errors import ConfigError, DeviceError, first_line
from vegrip.messages import ContactEstimate, Lifecycle
from vegrip.transport.codec import Frame
from vegrip.transport.codec.database import database

NMT, SYNC, EMCY, SDO_ANSWER, SDO_REQUEST, HEARTBEAT = 0x000, 0x080, 0x080, 0x580, 0x600, 0x700
LAST_NODE: Final = 127

FIRST_FINGER: Final = 32  # node-ID of finger 0 of hand 0, unless configured otherwise
GRASP_NODE_ID: Final = 16  # node-ID of the grasp force node, unless configured otherwise

COMMANDS, MARGINS, HEALTH, STATES, STATUS = 0x2100, 0x2110, 0x2120, 0x2200, 0x2130
ESTIMATES, REFUSAL, PARAMETERS = 0x2300, 0x2400, 0x3000
"""Indices of the objects of the grasp force node; tools/object_dictionary.py writes its EDS file."""
ESTIMATED: Final = tuple(
    name
    for name in ContactEstimate.__slots__
    if name not in ("stamp", "finger", "seq", "in_contact", "channels")
)

OF_A_FINGER: Final = {
    # classic frame of the DBC: base of the COB-ID, to which the node of the finger is added
    "FingertipState1": 0x180,  # TPDO 1 to 3 of the finger
    "FingertipState2": 0x280,
    "FingertipState3": 0x380,
    "ForceCommand": 0x200,  # RPDO 1 to 3 of the finger
    "SlipMargin": 0x300,
    "ModelHealth": 0x400,
}
OF_THE_GRASP: Final = {"NodeStatus": 0x180}  # TPDO 1 of the grasp force node
OUT_OF_A_FINGER: Final = frozenset(name for name in OF_A_FINGER if name.startswith("FingertipState"))
STATE_COB_IDS: Final = frozenset(OF_A_FINGER[name] for name in OUT_OF_A_FINGER)


@dataclass(frozen=True)
class CanopenSettings:
    """``[transport]`` with ``kind = "canopen"``."""

    kind: str = parameter("canopen")
    interface: str = parameter("vegrip", doc="python-can interface: vegrip, socketcan, virtual, slcan, ...")
    channel: str = parameter("vegrip0", doc="name of the bus or device")
    bitrate: int = parameter(1_000_000, unit="bit/s", low=10_000, high=1_000_000)
    options: dict[str, Any] = parameter({}, doc="anything else python-can's interface understands")
    role: str = parameter("grasp", choices=("grasp", "hand", "listen"), doc="which end of the bus this is")
    node_id: int = parameter(GRASP_NODE_ID, low=1, high=LAST_NODE, doc="of the grasp force node")
    first_finger: int = parameter(FIRST_FINGER, low=1, high=LAST_NODE, doc="node-ID of finger 0 of hand 0")
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


def frame_base(name: str) -> int:
    return int(database().get_message_by_name(name).frame_id)


def finger_nodes(first: int, hand: int, fingers: int) -> tuple[int, ...]:
    """Return the node-IDs of the fingers of a hand: ``first + 8 hand + number``."""
    nodes = tuple(first + 8 * hand + number for number in range(fingers))
    if nodes and nodes[-1] > LAST_NODE:
        raise ConfigError(f"finger number {fingers - 1} would be node {nodes[-1]}; the last is {LAST_NODE}")
    return nodes


def identifiers(fingers: tuple[int, ...], grasp: int, hand: int) -> Mapping[int, int]:
    """Return COB-ID -> identifier of the classic frame, for all frames of a hand."""
    stride = 8 * hand
    found = {
        base + node: frame_base(name) + stride + number
        for name, base in OF_A_FINGER.items()
        for number, node in enumerate(fingers)
    }
    return found | {base + grasp: frame_base(name) + stride for name, base in OF_THE_GRASP.items()}


CLAIM_LISTEN_NS = (
    300_000_000  # [ns] longer than a heartbeat of a node of ours, and than the answer to a question takes
)
LAST_WORDS = 0.05  # [s] for a frame to leave before the bus is closed
QUESTION = bytes([0x40, 0x00, 0x10, 0, 0, 0, 0, 0])  # read the device type, which every device has


def claim(
    nodes: tuple[int, ...],
    send: Callable[[int, bytes], None],
    receive: Callable[[float], Frame | None],
    now: Callable[[], int],
) -> None:
    """Ask whether another node has one of ``nodes``; listen for ``CLAIM_LISTEN_NS``.

    Raises:
        DeviceError: another node does. Before that EMCY 8150h is sent, lifecycle "unconfigured".

    """
    for node in nodes:
        send(SDO_REQUEST + node, QUESTION)
    signs = {service + node: node for service in (HEARTBEAT, SDO_ANSWER, EMCY) for node in nodes}
    end = now() + CLAIM_LISTEN_NS
    while (left := end - now()) > 0:
        frame = receive(left / 1e9)
        if frame is not None and frame.arbitration_id in signs:
            node = signs[frame.arbitration_id]
            send(EMCY + node, bytes([0x50, 0x81, 0x11, 0, node, 0, 0, 0]))
            time.sleep(LAST_WORDS)
            raise DeviceError(
                f"the node-ID {node} is taken by another node on this bus; "
                "choose another (node_id, first_finger) or switch that node off"
            )


def read_eds(name: str, node: int, like: str) -> ObjectDictionary:
    """Return the object dictionary in the EDS file ``name``, which must agree with ``like`` of ``proto/``.

    They are of the same product, with the same mapping of every PDO; an empty name stands for ``like``.
    """
    with as_file(files("vegrip.proto").joinpath(like)) as path:
        shipped = _import(path, node)
    if not name:
        return shipped
    found = _import(Path(name), node)
    difference = difference_of(found, shipped)
    if difference:
        raise ConfigError(f"{name} does not describe this device: {difference}; use {like} of vegrip.proto")
    return found


def difference_of(found: ObjectDictionary, expected: ObjectDictionary) -> str:
    """Return the first difference in identity and PDOs, "" if there is none."""
    for index, sub in essentials(expected):
        try:
            value = _entry(found, index, sub).default
        except KeyError:
            return f"object {index:04X}sub{sub} is missing"
        wanted = _entry(expected, index, sub).default
        if value != wanted:
            return f"object {index:04X}sub{sub} is {_hex(value)}, not {_hex(wanted)}"
    return ""


def essentials(dictionary: ObjectDictionary) -> list[tuple[int, int]]:
    """Return index and sub-index of what makes the device: type, product, revision, PDO mappings."""
    mappings = [index for index in dictionary if 0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00]
    mapped = [(index, sub) for index in mappings for sub in dictionary[index].subindices]
    return [(0x1000, 0), (0x1018, 2), (0x1018, 3), *mapped]


def wanted_value(dictionary: ObjectDictionary, index: int, sub: int) -> int:
    return int(_entry(dictionary, index, sub).default or 0)


def _entry(dictionary: ObjectDictionary, index: int, sub: int) -> ODVariable:
    found = dictionary[index]
    return found if isinstance(found, ODVariable) else found[sub]


def _import(path: Path, node: int) -> ObjectDictionary:
    if path.suffix.lower() not in (".eds", ".dcf"):
        raise ConfigError(f"{path} is no EDS file; its name must end in .eds or .dcf")
    try:
        return canopen.import_od(str(path), node)
    except OSError as error:
        raise ConfigError(f"{path} cannot be read ({error.strerror})") from None
    except (configparser.Error, ValueError, KeyError, AttributeError) as error:
        raise ConfigError(f"{path} is not a valid EDS file: {first_line(error)}") from None


def _hex(value: object) -> str:
    return hex(value) if isinstance(value, int) else str(value)


SendRaw = Callable[[int, bytes], None]
"""Takes COB-ID and data; never raises."""


class PeriodicTask:
    """A message sent once in a while; what ``canopen`` calls a periodic message task."""

    def __init__(self, can_id: int, data: bytes, period: float, now: int, owner: "LoopNetwork") -> None:
        self.can_id, self.data = can_id, bytes(data)
        self.due = now
        self._period = max(round(period * NS), 1_000_000)
        self._owner = owner

    def update(self, data: bytes) -> None:
        self.data = bytes(data)

    def stop(self) -> None:
        self._owner.tasks.discard(self)

    def serve(self, now: int) -> None:
        """Send if due, on the grid it began on; what was missed is not made up for."""
        if now >= self.due:
            self._owner.send_message(self.can_id, self.data)
            self.due += self._period * ((now - self.due) // self._period + 1)


class LoopNetwork(canopen.Network):  # type: ignore[misc]
    """A network without threads, whose owner feeds :meth:`receive`, and calls :meth:`serve` when due."""

    def __init__(self, send: SendRaw, now: Callable[[], int]) -> None:
        super().__init__()
        self.tasks: set[PeriodicTask] = set()
        self.malformed = 0  # frames that a service could not read
        self._send = send
        self._now = now

    @property
    def due(self) -> int:
        """When the next message must be sent [ns]."""
        return min((task.due for task in self.tasks), default=2**63 - 1)

    def serve(self, now: int) -> None:
        for task in tuple(self.tasks):
            task.serve(now)

    def receive(self, can_id: int, data: bytes, stamp: int) -> None:
        """Let the services have a frame; one they cannot read is counted."""
        try:
            self.notify(can_id, bytearray(data), stamp / NS)
        except Exception as error:  # noqa: BLE001 (a frame of the wrong length must not end the loop)
            self.malformed += 1
            logging.getLogger("vegrip.canopen").debug("frame %x: %r", can_id, error)

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        if not remote:
            self._send(can_id, bytes(data))

    def send_periodic(
        self,
        can_id: int,
        data: bytes,
        period: float,
        remote: bool = False,  # noqa: ARG002 (as the base class has it)
    ) -> PeriodicTask:
        """Send ``data`` every ``period`` [s], for the first time at once."""
        task = PeriodicTask(can_id, data, period, self._now(), self)
        self.tasks.add(task)
        return task


INITIALISING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
START, STOP, ENTER_PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130

STATE_OF: Final = {
    Lifecycle.UNCONFIGURED: STOPPED,
    Lifecycle.INACTIVE: PRE_OPERATIONAL,
    Lifecycle.ACTIVE: OPERATIONAL,
    Lifecycle.FINALIZED: STOPPED,
}
TRANSITIONS_OF_COMMAND: Final = {
    # command: the lifecycle states to go through
    START: (Lifecycle.ACTIVE,),
    STOP: (Lifecycle.UNCONFIGURED,),
    ENTER_PRE_OPERATIONAL: (Lifecycle.INACTIVE,),
    RESET_NODE: (Lifecycle.UNCONFIGURED, Lifecycle.INACTIVE),
    RESET_COMMUNICATION: (Lifecycle.INACTIVE,),
}


def nmt_state(lifecycle: Lifecycle, *, is_on_hold: bool) -> int:
    return OPERATIONAL if is_on_hold else STATE_OF[lifecycle]


TIME_COB_ID: Final = 0x100  # COB-ID
PRODUCED: Final = 1 << 30  # in object 1012h
CONSUMED: Final = 1 << 31

_EPOCH: Final = int(datetime(1984, 1, 1, tzinfo=UTC).timestamp())  # [s] since 1970
_DAY: Final = 86_400  # [s]
_TIME_OF_DAY: Final = struct.Struct("<IH")
_MILLISECOND: Final = NS // 1000


def pack_time(time_of_day: int) -> bytes:  # [ns] since 1970
    days, rest = divmod(time_of_day - _EPOCH * NS, _DAY * NS)
    return _TIME_OF_DAY.pack(rest // _MILLISECOND, days)


def unpack_time(data: bytes) -> int | None:
    """Return the time of a TIME message [ns since 1970], None when it is none."""
    if len(data) != _TIME_OF_DAY.size:
        return None
    counted, days = (int(number) for number in _TIME_OF_DAY.unpack(data))
    milliseconds = counted & 0x0FFF_FFFF  # four bits are reserved
    if milliseconds >= _DAY * 1000:
        return None
    return (_EPOCH + days * _DAY) * NS + milliseconds * _MILLISECOND


class TimeProducer(PeriodicTask):
    """Sends the wall clock of this machine every ``period`` [s]."""

    def __init__(self, period: float, now: int, owner: LoopNetwork) -> None:
        super().__init__(TIME_COB_ID, b"", period, now, owner)

    def serve(self, now: int) -> None:
        if now >= self.due:
            self.update(pack_time(time.time_ns()))
        super().serve(now)
