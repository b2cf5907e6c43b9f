"""What a contact went through while rows were lost: a motion in no row, which its memory keeps.

Between the rows beside a gap the motion is taken as straight. The mean of the true one over the gap differs
from that by as much as it does in other stretches of the recording that are as long. A memory that lasts much
longer than the gap feels later no more than that mean of what moved in it, so a bump with the same mean
stands for it: up at the last row before the gap, and down in a straight line to its end.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import median_filter

from vegrip.types import Floats

MIN_GAP_STEPS = 2.5  # of the usual step around it
AROUND = 9  # steps that say what is usual
MAX_STRETCHES = 2000  # of the recording, that a gap is compared with
TOUCHED_SHARE = 0.5  # of the depth after a gap in which the tip touched, that it may have had at once


def rows_after_gaps(t: Floats, first: Floats) -> NDArray[np.int64]:
    """Return the first row after each gap of ``t`` (n,) [s]; ``first`` is 1 where an episode begins."""
    steps = np.diff(t)
    steps[first[1:] > 0.0] = np.median(steps)
    usual = median_filter(steps, AROUND, mode="nearest")
    rows: NDArray[np.int64] = np.flatnonzero(steps > MIN_GAP_STEPS * usual) + 1
    return rows


def unseen_bumps(t: Floats, first: Floats, depth: Floats, after: NDArray[np.int64]) -> Floats:
    """Return the bump (n,) [m] of one standard deviation before each of the rows ``after`` a gap.

    ``depth`` (n,) [m] is 0 where the tip at rest touches. A motion that goes farther than is usual in such a
    time is as much less sure; of one that begins in the air the instant of touch is not known either.
    """
    bumps = np.zeros(t.size)
    way = cumulative_trapezoid(depth, t, initial=0)
    episode = np.cumsum(first > 0.0)
    for i in after.tolist():
        low = np.arange(0, t.size, max(t.size // MAX_STRETCHES, 1))
        high = np.searchsorted(t, t[low] + t[i] - t[i - 1])
        low, high = low[high < t.size], high[high < t.size]
        same = (high > low) & (episode[low] == episode[high])
        low, high = low[same], high[same]
        ends = depth[high] - depth[low]
        off = (way[high] - way[low]) / (t[high] - t[low]) - 0.5 * (depth[low] + depth[high])
        farther = abs(depth[i] - depth[i - 1]) / max(_rms(ends), 1e-12)
        touched = TOUCHED_SHARE * depth[i] - depth[i - 1] if depth[i - 1] < 0.0 < depth[i] else 0.0
        bumps[i - 1] = max(2.0 * _rms(off) * max(farther, 1.0), touched)
    return bumps


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values * values))) if values.size else 0.0
