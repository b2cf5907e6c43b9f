"""Slow wandering of a sensor, beside its white noise: an Ornstein-Uhlenbeck process by maximum likelihood.

    ``y = X b + w + e``,   ``w+ = w exp(-dt / tau) + noise``,   ``e ~ N(0, white^2)``

in stretches where nothing else acts: clear of the surface, or in the difference of two episodes with the same
motion. X holds what is no noise there (a constant, a drift, another gain); its coefficients b are integrated
out (restricted likelihood [PattersonThompson1971]_: profiled out, they take a third of the slow part along).
The slow part is believed when the likelihood pays for its two parameters.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, minimize

from vegrip.compiled import njit
from vegrip.types import Floats

MIN_SLOW_GAIN_NATS = 8.0  # [nats] that the slow part has to gain
LOG_LOW, LOG_HIGH = (
    (-5.0, -7.0, -7.0),
    (5.0, 3.0, 7.0),
)  # ln of white and slow over the guess, of the time [s]
MAX_ROWS = 40_000  # from which a noise is estimated, to half a percent
START_TIMES_S = (0.3, 1.0, 3.0, 10.0)  # [s] where the search begins


@dataclass(frozen=True)
class OuNoise:
    """White std, slow std and its time constant; slow is 0 where it does not pay, or is ``beyond`` noise."""

    white: float
    slow: float
    time: float
    gain: float  # [nats] of the slow part
    beyond: bool = False


def estimate_ou_noise(t: Floats, first: Floats, y: Floats, X: Floats, rough: float) -> OuNoise:
    """Estimate the noise of ``y`` (n,), NaN where it does not count, beside ``X`` (n, m).

    ``first`` is 1 where a stretch begins that does not know of the one before; ``rough``: a guess of the
    white std, same unit as y. Of more than MAX_ROWS rows, stretches spread evenly over them count.
    """
    if t.size > MAX_ROWS:
        some = spread_rows(first)
        t, first, y, X = t[some], first[some], y[some], X[some]
        X = X[:, np.any(X != 0.0, axis=0)]
    used = np.isfinite(y).astype(np.float64)
    columns = np.nan_to_num(np.column_stack([y, X]))
    longest = max((t[-1] - t[0]) / 3.0, 1e-9)

    def cost(white: float, slow: float, time: float) -> float:
        errors, scale = innovations(t, first, white**2, slow**2, time, used, columns)
        G = errors.T @ errors
        if G.shape[0] == 1:
            return 0.5 * float(G[0, 0]) + scale
        L = np.linalg.cholesky(G[1:, 1:] + 1e-12 * np.diag(np.diag(G)[1:]))
        along = np.linalg.solve(L, G[1:, 0])
        return 0.5 * float(G[0, 0] - along @ along) + scale + float(np.sum(np.log(np.diag(L))))

    def alone(p: Floats) -> float:
        return cost(rough * float(np.exp(np.clip(p[0], -5.0, 5.0))), 0.0, 2.0)

    def of(p: Floats) -> tuple[float, float, float]:
        a, b, c = np.clip(p, LOG_LOW, LOG_HIGH)
        return rough * float(np.exp(a)), rough * float(np.exp(b)), min(float(np.exp(c)), longest)

    def both(p: Floats) -> float:
        return cost(*of(p))

    plain = _least(alone, np.array([0.0]))
    white = rough * float(np.exp(plain.x[0]))
    starts = [[plain.x[0], -0.7, float(np.log(time))] for time in START_TIMES_S if time < longest]
    if not starts:
        return OuNoise(white, 0.0, 2.0, 0.0)
    best = min(starts, key=lambda p: both(np.array(p)))
    found = _least(both, np.array(best))
    gain = float(plain.fun - found.fun)
    if gain < MIN_SLOW_GAIN_NATS:
        return OuNoise(white, 0.0, 2.0, max(gain, 0.0))
    if found.x[1] > LOG_HIGH[1] - 0.1:
        return OuNoise(rough, 0.0, 2.0, gain, beyond=True)
    return OuNoise(*of(found.x), gain)


def spread_rows(first: Floats, most: int = MAX_ROWS) -> NDArray[np.int64]:
    """Return at most ``most`` rows: whole stretches spread evenly, or the beginnings of a few long ones."""
    starts = np.flatnonzero(first > 0.5)
    lengths = np.diff(np.append(starts, first.size))
    count = min(starts.size, max(4, most * starts.size // first.size))
    chosen = np.linspace(0, starts.size - 1, count).round().astype(int)
    each = np.minimum(lengths[chosen], most // count)
    return np.concatenate([np.arange(starts[i], starts[i] + n) for i, n in zip(chosen, each, strict=True)])


@njit
def innovations(
    t: Floats, first: Floats, white: float, slow: float, time: float, used: Floats, columns: Floats
) -> tuple[Floats, float]:
    """Return the one-step prediction errors of ``columns`` (n, m) over their std, and the sum of ln std.

    ``white`` and ``slow`` are variances; the recursion of :mod:`vegrip.identification.fit.whitening` for a
    tip that rests.
    """
    n, m = columns.shape
    out, x = np.zeros((n, m)), np.zeros(m)
    scale, P = 0.0, slow
    for i in range(n):
        if first[i] > 0.5:
            x[:] = 0.0
            P = slow
        else:
            kept = np.exp(-(t[i] - t[i - 1]) / time)
            x *= kept
            P = kept * kept * P + slow * (1.0 - kept * kept)
        if used[i] > 0.5:
            S = P + white
            scale += 0.5 * np.log(S)
            for c in range(m):
                v = columns[i, c] - x[c]
                x[c] += P / S * v
                out[i, c] = v / np.sqrt(S)
            P -= P * P / S
    return out, scale


def _least(cost: Callable[[Floats], float], start: Floats) -> OptimizeResult:
    """Minimise by simplex; its first steps given, because scipy's are relative and one start is ln 1 = 0."""
    simplex = np.vstack([start, *(start + 0.3 * row for row in np.eye(start.size))])
    options: Any = {"xatol": 1e-2, "fatol": 1e-2, "initial_simplex": simplex}
    return minimize(cost, start, method="Nelder-Mead", options=options)
