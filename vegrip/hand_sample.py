"""What all fingers of a hand sensed at one instant, as arrays: a message for each of them costs more."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vegrip.messages import FingertipState
from vegrip.types import Flags, Floats


class HandSample(NamedTuple):
    """One row for each finger."""

    seq: int
    stamps: NDArray[np.int64]  # (n,) [ns]
    values: Floats  # (n, 9) as FingertipState has them, from the normal force on; NaN = not measured
    lost: Flags  # (n,) these fingers report nothing

    def states(self, fingers: Sequence[str]) -> list[FingertipState]:
        """Return what ``fingers`` report, without those that report nothing."""
        rows = zip(self.stamps.tolist(), fingers, self.values.tolist(), self.lost.tolist(), strict=True)
        return [
            FingertipState(stamp, finger, self.seq, *values)
            for stamp, finger, values, missing in rows
            if not missing
        ]
