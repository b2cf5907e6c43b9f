"""Is a node-ID free? Asked before it is used: two nodes with one ID disturb each other for good."""

import time
from collections.abc import Callable

from vegrip.canopen.connection_set import EMCY, HEARTBEAT, SDO_ANSWER, SDO_REQUEST
from vegrip.errors import DeviceError
from vegrip.transport.codec import Frame

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
