"""The last states of a finger, some as messages and some as the compiled step kept them.

Rows become messages only when they are asked for: a message costs a third of a compiled step.
"""

from collections import deque
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

    def last(self, count: int) -> "KeptStates":
        """Return the last ``count``, or all where there are fewer."""
        part: Any = slice(max(len(self) - count, 0), None)
        return KeptStates(self.finger, self.stamps[part], self.numbers[part], self.values[part])


class RecentStates:
    """At least the last ``most`` states; iterating gives them as messages, oldest first.

    Args:
        most: how many are kept; more, until a whole group of rows can be dropped.

    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._groups: deque[KeptStates | tuple[FingertipState]] = deque()
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[FingertipState]:
        return (state for group in self._groups for state in group)

    def __copy__(self) -> "RecentStates":
        copied = RecentStates(self._most)
        copied._groups, copied._count = self._groups.copy(), self._count
        return copied

    def append(self, state: FingertipState) -> None:
        """Keep a message."""
        self._keep((state,))

    def extend(self, rows: KeptStates) -> None:
        """Keep what the compiled step kept."""
        if len(rows):
            self._keep(rows)

    def last(self, count: int) -> list[FingertipState]:
        """Return the last ``count`` states, or all where there are fewer."""
        found: list[FingertipState] = []
        for group in reversed(self._groups):
            if len(found) >= count:
                break
            part = group.last(count - len(found)) if isinstance(group, KeptStates) else group
            found[:0] = part
        return found

    def after(self, stamp: int) -> list[FingertipState]:
        """Return the states at the end whose stamps [ns] are all later than ``stamp``."""
        later: list[KeptStates | tuple[FingertipState]] = []
        for group in reversed(self._groups):
            if (int(group.stamps[-1]) if isinstance(group, KeptStates) else group[0].stamp) <= stamp:
                break
            later.append(group)
        return [state for group in reversed(later) for state in group if state.stamp > stamp]

    def _keep(self, group: KeptStates | tuple[FingertipState]) -> None:
        self._groups.append(group)
        self._count += len(group)
        while self._count - len(self._groups[0]) >= self._most:
            self._count -= len(self._groups.popleft())
