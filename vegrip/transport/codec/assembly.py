"""Putting the parts of a message together: in order, of one cycle, or not at all."""

from typing import Final, NamedTuple

from vegrip.transport.codec.layout import Part
from vegrip.transport.codec.members import Cells
from vegrip.transport.codec.sequence import Sequence

WINDOW_NS: Final = 5_000_000
"""[ns] All parts arrive within this. It must be shorter than 15 cycles, after which the counter of a classic
frame comes back and a late part could pass for one of the present cycle (15 cycles are 7.5 ms at 2 kHz)."""


class Whole(NamedTuple):
    """All cells of a message, its running number, and when its first part arrived."""

    cells: Cells
    seq: int
    stamp: int
    time: int  # the sender's time on the wire


class Assembly:
    """The stream of one kind of message of one finger.

    :meth:`put` returns the message when its last part has arrived, None while more must come, or the name of
    the reason for refusing the part.
    """

    __slots__ = ("_absent", "_cells", "_counter", "_expected", "_stamp", "_time", "incomplete", "sequence")

    def __init__(self, parts: tuple[Part, ...], reach: int = 0) -> None:
        self.sequence = Sequence(parts[0].modulus, reach if len(parts) == 1 else 0)
        self.incomplete = 0  # messages begun and never finished
        self._absent = [sum((p.absent for p in parts[number:]), ()) for number in range(len(parts) + 1)]
        self._cells: Cells = ()
        self._counter, self._expected = -1, 0  # of the open message; 0 expected: none is open
        self._stamp = self._time = 0

    def reset(self) -> None:
        """Begin a new stream; what was counted stays counted."""
        self.sequence.last = -1
        self._counter, self._expected = -1, 0

    @property
    def lost(self) -> int:
        """Messages that never arrived, or not whole."""
        return self.sequence.lost + self.incomplete

    def put(
        self, number: int, counter: int, is_last: bool, cells: Cells, stamp: int, time: int
    ) -> Whole | str | None:
        """Take one part that has passed all checks of its own."""
        refusal = self._begin(counter, stamp, time) if number == 1 else self._continue(number, counter, stamp)
        if refusal:
            return refusal
        self._cells += cells
        self._expected = number + 1
        if not is_last and number < len(self._absent) - 1:
            return None
        self._expected = 0
        return Whole(self._cells + self._absent[number], self.sequence.last, self._stamp, self._time)

    def _begin(self, counter: int, stamp: int, time: int) -> str:
        if self.sequence.advance(counter, stamp) is None:
            return "counter"
        self._abandon()
        self._cells, self._counter, self._stamp, self._time = (), counter, stamp, time
        return ""

    def _continue(self, number: int, counter: int, stamp: int) -> str:
        is_same = counter == self._counter
        if is_same and number == self._expected and stamp - self._stamp <= WINDOW_NS:
            return ""
        repeated = is_same and (number < self._expected or not self._expected)
        if repeated or self.sequence.is_behind(counter):
            return "counter"  # an old part does no harm to the open message
        self._abandon()
        return "incomplete"

    def _abandon(self) -> None:
        self.incomplete += self._expected > 0
        self._expected = 0
