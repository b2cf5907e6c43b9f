"""Where things stand in the object dictionaries, and the node-IDs unless configured otherwise."""

from typing import Final

from vegrip.messages import ContactEstimate

FIRST_FINGER: Final = 32  # node-ID of finger 0 of hand 0, unless configured otherwise
GRASP_NODE_ID: Final = 16  # node-ID of the grasp force node, unless configured otherwise
MAX_FINGERS: Final = 8
NO_RTR: Final = 0x4000_0000
EVENT_DRIVEN = 254
HEARTBEAT_TIME, HEARTBEAT_LIMIT = 200, 500  # [ms]

COMMANDS, MARGINS, HEALTH, STATES, STATUS = 0x2100, 0x2110, 0x2120, 0x2200, 0x2130
ESTIMATES, REFUSAL, PARAMETERS = 0x2300, 0x2400, 0x3000
ESTIMATED: Final = tuple(
    name
    for name in ContactEstimate.__slots__
    if name not in ("stamp", "finger", "seq", "in_contact", "channels")
)
