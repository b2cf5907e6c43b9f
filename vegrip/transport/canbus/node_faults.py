"""What goes wrong at one node of a virtual CAN bus, on purpose, by chance that is seeded."""

from dataclasses import dataclass

from vegrip.config import parameter
from vegrip.transport.canbus.bus_records import NOBODY


@dataclass(frozen=True)
class NodeFaults:
    """Faults of one node; the default has none. Shares are per frame, or per attempt to send one."""

    loss: float = parameter(
        0.0, low=0.0, high=1.0, doc="share of its frames that no node receives, though the bus carries them"
    )
    corruption: float = parameter(
        0.0, low=0.0, high=1.0, doc="share of its attempts in which a bit is disturbed for all nodes"
    )
    misreading: float = parameter(
        0.0, low=0.0, high=1.0, doc="share of others' frames in which this node alone misreads a bit"
    )
    flips: float = parameter(
        0.0,
        low=0.0,
        high=1.0,
        doc="share of its frames with a bit of data wrong that no CRC of the bus catches",
    )
    delay: float = parameter(0.0, unit="s", low=0.0, high=10.0, doc="from sending to asking for the bus")
    jitter: float = parameter(0.0, unit="s", low=0.0, high=10.0, doc="at most added to the delay")
    babble: int = parameter(
        NOBODY, low=NOBODY, high=0x7FF, doc="identifier it sends without pause; -1 = it does not"
    )
    seed: int = parameter(0, low=0, doc="of its chance")


NO_FAULTS = NodeFaults()
