"""One more sample of eq. (20): the recursion against the hereditary sum over all samples so far, at 1 kHz.

Both give the force at the newest sample. Theirs is the plain sum vectorised with numpy, one exponential per
branch and sample, the midpoint rule of the integral; ours is one compiled step called from Python.
"""

import numpy as np

from benchmarks._timing import compared
from vegrip.contact.hereditary import advance, filtered

RATE = 1000  # [Hz]
AMPLITUDES = np.array([0.2, 0.1])
RATES = np.array([3.1, 0.25])  # [1/s]
SMALLEST = {"HISTORIES": {"1s": 1}}
HISTORIES = {"1s": 1, "60s": 60, "1h": 3600}  # [s]


def run() -> dict[str, dict[str, float]]:
    return {f"recursion_vs_direct_sum_{name}": _compare(seconds) for name, seconds in HISTORIES.items()}


def _compare(seconds: int) -> dict[str, float]:
    t = np.arange(seconds * RATE + 1) / RATE
    N_e = 2 + np.sin(3 * t)
    _agree(t[-2000:], N_e[-2000:])
    memory = np.array([1.0, 1.0])
    before, now = float(N_e[-2]), float(N_e[-1])
    rises, middles = np.diff(N_e, prepend=0.0), np.concatenate([[t[0]], (t[1:] + t[:-1]) / 2])

    def ours() -> float:
        return advance(memory, before, now, 1 / RATE, AMPLITUDES, RATES)

    def theirs() -> float:
        return direct_sum(t[-1], middles, rises)

    return compared(ours, theirs)


def direct_sum(end: float, middles: np.ndarray, rises: np.ndarray) -> float:
    """``sum_j g(t - s_j) dN_e(s_j)``."""
    g = (
        1
        - AMPLITUDES.sum()
        + sum(c * np.exp(-nu * (end - middles)) for c, nu in zip(AMPLITUDES, RATES, strict=True))
    )
    return float(g @ rises)


def _agree(t: np.ndarray, N_e: np.ndarray) -> None:
    middles = np.concatenate([[t[0]], (t[1:] + t[:-1]) / 2])
    plain = direct_sum(t[-1], middles, np.diff(N_e, prepend=0.0))
    assert abs(plain - filtered(t, N_e, AMPLITUDES, RATES)[-1]) < 1e-6
