"""What a contact went through while rows were lost: a motion in no row, which its memory keeps.

Between the rows beside a gap the motion is taken as straight. The mean of the true one over the gap differs
from that by as much as it does in other stretches of the recording that are as long. A memory that lasts much
longer than the gap feels later no more than that mean of what moved in it, so a bump with the same mean
stands for it: up at the last row before the gap, and down in a straight line to its end.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from vegrip.types import Floats

MIN_GAP_STEPS = 2.5  # of the usual step around it
AROUND = 9  # steps that say what is usual
MAX_STRETCHES = 2000  # of the recording, that a gap is compared with
NO_GAPS = np.zeros((0, 2), dtype=np.int64)
TOUCHED_SHARE = 0.5  # of the depth after a gap in which the tip touched, that it may have had at once


def find_gaps(t: Floats, first: Floats, displacement: Floats) -> NDArray[np.int64]:
    """Return the last row before each gap of ``displacement`` (n,) [m] and the first after it, (gaps, 2).

    Rows may be missing or hold no displacement, NaN. ``first`` is 1 where an episode begins.
    """
    known = np.flatnonzero(np.isfinite(displacement))
    steps = np.diff(t[known])
    steps[np.diff(np.cumsum(first > 0.0)[known]) > 0] = np.median(steps)
    usual = np.median(sliding_window_view(np.pad(steps, AROUND // 2, "edge"), AROUND), axis=1)
    at = np.flatnonzero(steps > MIN_GAP_STEPS * usual)
    return np.stack([known[at], known[at + 1]], axis=1)


def unseen_bumps(t: Floats, first: Floats, depth: Floats, gaps: NDArray[np.int64]) -> Floats:
    """Return the bump (n,) [m] of one standard deviation in each of the ``gaps``.

    ``depth`` (n,) [m] is 0 where the tip at rest touches. A motion that goes farther than is usual in such a
    time is as much less sure; of one that begins in the air the instant of touch is not known either.
    """
    bumps = np.zeros(t.size)
    way = np.r_[0.0, np.cumsum(0.5 * (depth[1:] + depth[:-1]) * np.diff(t))]
    episode = np.cumsum(first > 0.0)
    for before, after in gaps.tolist():
        low = np.arange(0, t.size, max(t.size // MAX_STRETCHES, 1))
        high = np.searchsorted(t, t[low] + t[after] - t[before])
        low, high = low[high < t.size], high[high < t.size]
        same = (high > low) & (episode[low] == episode[high])
        low, high = low[same], high[same]
        ends = depth[high] - depth[low]
        off = (way[high] - way[low]) / (t[high] - t[low]) - 0.5 * (depth[low] + depth[high])
        farther = abs(depth[after] - depth[before]) / max(_rms(ends), 1e-12)
        is_touched = depth[before] < 0.0 < depth[after]
        touched = TOUCHED_SHARE * depth[after] - depth[before] if is_touched else 0.0
        bumps[before] = max(2.0 * _rms(off) * max(farther, 1.0), touched)
    return bumps


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values * values))) if values.size else 0.0
