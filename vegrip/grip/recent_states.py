"""The last states of a finger, as its step kept them.

Rows become messages only when they are asked for: a message costs a third of a compiled step.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.messages import FingertipState
from vegrip.types import Floats


@dataclass(frozen=True, slots=True)
class KeptStates:
    """States that the compiled step believed, in their order.

    Args:
        finger: whose they are.
        stamps: [ns], shape (n,).
        numbers: their counters, shape (n,).
        values: what was measured, in the order of FingertipState, and 1 where it touched; shape (n, 10).

    """

    finger: str
    stamps: NDArray[np.int64]
    numbers: NDArray[np.int64]
    values: Floats

    def __len__(self) -> int:
        return len(self.stamps)

    def __iter__(self) -> Iterator[FingertipState]:
        rows = zip(self.stamps.tolist(), self.numbers.tolist(), self.values.tolist(), strict=True)
        return (FingertipState(stamp, self.finger, seq, *values[:-1]) for stamp, seq, values in rows)

    def after(self, stamp: int) -> list[FingertipState]:
        """Return the states at the end whose stamps [ns] are all later than ``stamp``."""
        early = np.flatnonzero(self.stamps <= stamp)
        part: Any = slice(int(early[-1]) + 1 if len(early) else 0, None)
        return list(KeptStates(self.finger, self.stamps[part], self.numbers[part], self.values[part]))
