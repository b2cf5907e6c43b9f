"""Fault confinement of one CAN node: two error counters and what they make of it [ISO2015]_.

===========================================  =======================================================
what happens                                 counter
===========================================  =======================================================
a sender sends an error flag                 transmit + 8
the same for want of an acknowledgement,     unchanged: a lone node never goes bus-off
by an error-passive sender
a receiver finds an error                    receive + 1
it was the first to: others answer its flag  receive + 8 more
a frame was sent                             transmit - 1
a frame was received                         receive - 1, and from above 127 to 127
===========================================  =======================================================

Error passive when a counter exceeds 127, bus-off when the transmit counter exceeds 255. A node that is off
recovers, error active with both at zero, after 128 times 11 recessive bits.
"""

from enum import IntEnum
from typing import Final

PASSIVE_LIMIT: Final = 127
OFF_LIMIT: Final = 255
WARNING: Final = 96
"""From here on controllers warn; nothing changes on the bus."""

RECOVERY_SEQUENCES: Final = 128
RECOVERY_BITS: Final = 11


class ErrorState(IntEnum):
    """What a node may still do."""

    ACTIVE = 0  # signals errors with dominant bits, which all others see
    PASSIVE = 1  # signals them with recessive bits, and waits 8 bits after each frame of its own
    OFF = 2  # takes no part in the bus


class Confinement:
    """The counters of one node."""

    __slots__ = ("missing", "receive", "transmit")

    def __init__(self) -> None:
        self.transmit = 0
        self.receive = 0  # kept within 8 bits, as the registers of controllers are
        self.missing = 0  # sequences of recessive bits still to be seen before a node that is off comes back

    @property
    def state(self) -> ErrorState:
        """The state that follows from the counters."""
        if self.transmit > OFF_LIMIT:
            return ErrorState.OFF
        is_passive = self.transmit > PASSIVE_LIMIT or self.receive > PASSIVE_LIMIT
        return ErrorState.PASSIVE if is_passive else ErrorState.ACTIVE

    @property
    def is_clean(self) -> bool:
        """Whether both counters are zero: frames that go well change nothing."""
        return not (self.transmit or self.receive)

    def sent(self) -> None:
        """Count a frame that was sent and acknowledged."""
        self.transmit = max(self.transmit - 1, 0)

    def received(self) -> None:
        """Count a frame that was received."""
        self.receive = PASSIVE_LIMIT if self.receive > PASSIVE_LIMIT else max(self.receive - 1, 0)

    def failed_to_send(self) -> None:
        """Count an error in a frame of its own."""
        self.transmit += 8
        if self.transmit > OFF_LIMIT:
            self.missing = RECOVERY_SEQUENCES

    def not_acknowledged(self) -> None:
        """Count a frame of its own that no node acknowledged."""
        if self.state is ErrorState.ACTIVE:
            self.failed_to_send()

    def failed_to_receive(self, is_first: bool) -> None:
        """Count an error in a frame of another; ``is_first``: the others only answered its flag."""
        self.receive = min(self.receive + (9 if is_first else 1), 255)

    def count_silence(self, sequences: int) -> bool:
        """Take note of ``sequences`` of 11 recessive bits; tell whether the node has recovered by them."""
        if self.state is not ErrorState.OFF:
            return False
        self.missing -= sequences
        if self.missing > 0:
            return False
        self.transmit = self.receive = self.missing = 0
        return True
