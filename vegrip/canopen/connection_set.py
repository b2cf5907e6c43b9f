"""Which COB-ID carries what: the predefined connection set of CiA 301, seen from the fingers.

A finger is one node, sensor and drive: its TPDOs are its state, its RPDOs what the grasp force node tells it.
So a finger needs no configuration, and the grasp force node sends on the RPDO identifiers of the fingers.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from vegrip.config import parameter
from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import ContactEstimate
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
    """Return the node-IDs of the fingers of a hand: ``first + 8 hand + number``.

    Raises:
        ConfigError: beyond the largest node-ID, 127.

    """
    nodes = tuple(first + 8 * hand + number for number in range(fingers))
    if nodes and nodes[-1] > LAST_NODE:
        raise ConfigError(f"finger number {fingers - 1} would be node {nodes[-1]}; the last is {LAST_NODE}")
    return nodes


def identifiers(fingers: tuple[int, ...], grasp: int, hand: int) -> Mapping[int, int]:
    """Return COB-ID -> identifier of the classic frame, for all frames of a hand.

    Args:
        fingers: node-ID of each finger, in the order of their numbers.
        grasp: node-ID of the grasp force node.
        hand: number of the hand in the identifiers of the DBC.

    """
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
        DeviceError: another node does. Before that the bus is told with EMCY 8150h, lifecycle "unconfigured".

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
