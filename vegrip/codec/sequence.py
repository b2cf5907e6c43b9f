"""Counters of received messages: a gap is a loss, a repeat or a step back is refused."""

from typing import Final

RESYNC: Final = 500_000_000
"""[ns] A stream silent for longer may go on anywhere: its sender has started again."""


class Sequence:
    """The counter of one stream, made an ever-growing number.

    A counter modulo ``m`` that moved by ``d = (counter - last) mod m`` is a repeat for d = 0, has lost
    d - 1 messages for d <= m // 2, and ran backwards for any larger d.

    >>> stream = Sequence(15)
    >>> [stream.advance(counter, stamp=0) for counter in (13, 14, 0, 0, 2, 1)]
    [13, 14, 15, None, 17, None]
    >>> stream.lost
    1
    """

    __slots__ = ("last", "lost", "modulus", "stamp")

    def __init__(self, modulus: int) -> None:
        self.modulus = modulus
        self.last = -1  # nothing received yet
        self.stamp = 0
        self.lost = 0

    def behind(self, counter: int) -> bool:
        """Whether ``counter`` is older than the last one taken."""
        return self.last >= 0 and (counter - self.last) % self.modulus > self.modulus // 2

    def advance(self, counter: int, stamp: int) -> int | None:
        """Return the running number of the message received at ``stamp`` [ns], None to refuse it."""
        if self.last < 0:
            self.last = counter
        else:
            step = (counter - self.last) % self.modulus
            silent = stamp - self.stamp > RESYNC
            if step == 0 or (step > self.modulus // 2 and not silent):
                return None
            self.last += step
            if not silent:
                self.lost += step - 1
        self.stamp = stamp
        return self.last
