"""What goes wrong at one node of a virtual CAN bus, on purpose, by chance that is seeded."""

from dataclasses import dataclass
from random import Random

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.transport.canbus.frame_time import BusFrame

NOBODY = -1


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


class Chance:
    """The dice of one node."""

    def __init__(self, faults: NodeFaults) -> None:
        self.faults = faults
        self._random = Random(faults.seed)  # noqa: S311 (no secret)

    def happens(self, share: float) -> bool:
        """Tell whether something happens that does in a ``share`` of all cases."""
        return share > 0.0 and self._random.random() < share

    def position(self, first: int, last: int) -> int:
        """Return one of the bits ``first`` .. ``last``."""
        return self._random.randint(first, max(first, last))

    def delayed(self, time: int) -> int:
        """Return when a frame sent at ``time`` [ns] asks for the bus [ns]."""
        faults = self.faults
        if not (faults.delay or faults.jitter):
            return time
        return time + round((faults.delay + faults.jitter * self._random.random()) * NS)

    def carried(self, frame: BusFrame) -> BusFrame:
        """Return what becomes of ``frame``: itself, or with one bit of its data wrong."""
        if not frame.data or not self.happens(self.faults.flips):
            return frame
        bit = self._random.randrange(8 * len(frame.data))
        data = bytearray(frame.data)
        data[bit // 8] ^= 1 << (bit % 8)
        return frame._replace(data=bytes(data))


NO_FAULTS = NodeFaults()
