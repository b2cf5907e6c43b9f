"""Where a noisy motion is straight: at rest, or at one speed.

The test is a hinge. Through the samples on both sides of an instant goes a line that may bend there,

    ``y = a + b u + c |u| + e``,   ``u = t - t_i``,   ``e ~ N(0, noise^2)``,

and ``c`` over its standard error is a standard normal number where nothing bends. The windows double from 8
samples on each side to 1024: a jerk shows in the short ones, a slow creep in the long ones. Of a bend only
the shortest window that sees it counts; a longer one that contains such a window says nothing. What is left
between two bends may be too short for the windows that would see its own: there, square and cube of time are
tested over the whole run.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.types import Floats

HALVES = (8, 16, 32, 64, 128, 256, 512, 1024)  # samples on each side of the instant
MAX_HINGE_STD = 4.0  # standard errors of the hinge; chance alone gets there in one window of 16 000
LINE, CUBIC = 1, 3  # degrees
CURVED = 9.0  # of two squared standard normal numbers; chance alone gets there in one run of 90


def straight(t: Floats, first: Floats, measured: Floats, noise: float) -> NDArray[np.bool_]:
    """Return for every sample (n,) whether ``measured`` [m] runs straight around it, to within the ``noise``.

    ``first`` is 1 where an episode begins; ``measured`` is NaN where missing. The first and last samples of
    an episode count as their neighbours within.
    """
    bent = np.zeros(t.size, dtype=np.bool_)
    for half in HALVES:
        bent |= _bends(t, first, measured, noise, half, MAX_HINGE_STD, bent)
    for low, high in _runs(~bent, first):
        bent[low:high] = _curvature(t[low:high], measured[low:high]) > CURVED * noise**2
    return ~bent


def _runs(wanted: NDArray[np.bool_], first: Floats) -> list[tuple[int, int]]:
    """Return where runs of ``wanted`` samples of one episode begin and end, of those a window fits into."""
    episode = np.cumsum(first > 0.5)
    at = np.flatnonzero(np.diff(np.where(wanted, episode, -1), prepend=-1, append=-1))
    return [(low, high) for low, high in pairwise(at.tolist()) if wanted[low] and high - low > CUBIC + 1]


def _curvature(t: Floats, measured: Floats) -> float:
    """Return how much the sum of squares [m^2] falls when square and cube of time are fitted to a run too."""
    known = ~np.isnan(measured)
    if np.count_nonzero(known) <= CUBIC:
        return 0.0
    u = np.interp(t[known], [t[0], t[-1]], [-1.0, 1.0])
    powers, _ = np.linalg.qr(np.vander(u, CUBIC + 1, increasing=True))
    return float(np.sum((powers[:, LINE + 1 :].T @ (measured[known] - measured[known][0])) ** 2))


@njit
def _bends(
    t: Floats, first: Floats, measured: Floats, noise: float, half: int, bent: float, known: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return the samples (n,) within a window of ``half`` that bends and holds none that is ``known`` to."""
    n = t.shape[0]
    out = np.zeros(n, dtype=np.bool_)
    bends_before = np.zeros(n + 1)  # how many known bends, and how many beginnings, come before a sample
    begun_before = np.zeros(n + 1)
    for i in range(n):
        bends_before[i + 1] = bends_before[i] + known[i]
        begun_before[i + 1] = begun_before[i] + (first[i] > 0.5)
    step = max(half // 8, 1)
    for i in range(half, n - half, step):
        low, high = i - half, i + half + 1
        if begun_before[high] > begun_before[low + 1] or bends_before[high] > bends_before[low]:
            continue
        hinge, information = _hinge(t, measured, low, i, high)
        if abs(hinge) * np.sqrt(information) > bent * noise:
            out[low:high] = True
    return out


@njit
def _hinge(t: Floats, measured: Floats, low: int, i: int, high: int) -> tuple[float, float]:
    """Return the bend ``c`` [m/s] of the line through the window, and 1 / var(c) for noise of one."""
    scale = t[high - 1] - t[low]
    level = measured[i] if not np.isnan(measured[i]) else 0.0
    s0, s1, s2, h0, h1, h2, y0, y1, yh = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(low, high):
        if np.isnan(measured[j]):
            continue
        y = measured[j] - level
        u = (t[j] - t[i]) / scale
        h = abs(u)
        s0, s1, s2 = s0 + 1.0, s1 + u, s2 + u * u
        h0, h1, h2 = h0 + h, h1 + h * u, h2 + h * h
        y0, y1, yh = y0 + y, y1 + y * u, yh + y * h
    det = s0 * s2 - s1 * s1
    if not det > 0.0:
        return 0.0, 0.0
    p, q = (h0 * s2 - h1 * s1) / det, (h1 * s0 - h0 * s1) / det  # |u| by the straight line
    left = h2 - p * h0 - q * h1
    if not left > 1e-9 * h2:
        return 0.0, 0.0
    return (yh - p * y0 - q * y1) / (left * scale), left * scale * scale
