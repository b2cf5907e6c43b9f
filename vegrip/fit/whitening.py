"""Whitening: from a residual of the normal force to independent errors of variance one.

What the model leaves is noise of the force sensor, white and slow, and the error of the smoothed motion times
the stiffness,

    ``residual = k error + b + e``,   ``b+ = b exp(-dt / tau) + noise``

a state-space model whose one-step prediction errors, over their standard deviations, are independent
[DurbinKoopman2012]_. Its gains do not depend on the residual, so it is a matrix: the same for every candidate
and for the derivatives. This is the likelihood of a filter that carries the displacement as a noisy state,
linear in the force.
"""

from dataclasses import dataclass

import numpy as np

from vegrip.compiled import njit
from vegrip.fit.motion import Motion
from vegrip.fit.smoother import Floats


@dataclass(frozen=True)
class ForceNoise:
    """Noise of the normal force: white std [N] (one or of every row), slow std [N], its time constant [s]."""

    white: float | Floats
    slow: float = 0.0
    time: float = 2.0


class Whitener:
    """The whitening matrix of a recording, as a recursion.

    Args:
        t: (n,) [s].
        first: (n,) 1 where an episode begins.
        motion: the smoothed motion.
        stiffness: (n,) [N/m] of the model at each sample; 0 in air.
        noise: of the force.
        used: (n,) rows with a force that counts.

    """

    def __init__(
        self,
        t: Floats,
        first: Floats,
        motion: Motion,
        stiffness: Floats,
        noise: ForceNoise,
        used: Floats,
    ) -> None:
        self._beside = (t, first, motion.pull, stiffness)
        self._time = noise.time
        white = np.full(t.size, 1.0) * np.square(noise.white)
        self._gain, self._scale = gains(
            t,
            first,
            motion.pull,
            motion.push,
            motion.start,
            stiffness,
            white,
            noise.slow**2,
            noise.time,
            used,
        )

    def __call__(self, columns: Floats) -> Floats:
        """Whiten residuals or derivatives, (n,) or (n, m); rows that do not count become 0."""
        matrix = np.ascontiguousarray(columns if columns.ndim == 2 else columns[:, None])
        white = whiten(*self._beside, self._time, self._gain, self._scale, matrix)
        return white if columns.ndim == 2 else np.ascontiguousarray(white[:, 0])

    @property
    def log_scale(self) -> float:
        """Sum of the logarithms of the standard deviations: the part of the likelihood without residual."""
        counted = self._scale > 0.0
        return -float(np.sum(np.log(self._scale[counted])))


@njit
def gains(
    t: Floats,
    first: Floats,
    pull: Floats,
    push: Floats,
    start: Floats,
    stiffness: Floats,
    white: Floats,
    S_b: float,
    time: float,
    used: Floats,
) -> tuple[Floats, Floats]:
    """Return the Kalman gains (n, 3) of error, its rate and b, and one over the std of the innovation."""
    n = t.shape[0]
    gain, scale = np.zeros((n, 3)), np.zeros(n)
    P = np.zeros((3, 3))
    for i in range(n):
        if first[i] > 0.5:
            P[:, :] = 0.0
            P[0, 0], P[1, 1], P[2, 2] = start[i, 0], start[i, 2], S_b
            P[0, 1] = P[1, 0] = start[i, 1]
        k = stiffness[i]
        if used[i] > 0.5:
            g0, g1, g2 = k * P[0, 0] + P[0, 2], k * P[1, 0] + P[1, 2], k * P[2, 0] + P[2, 2]
            S = k * g0 + g2 + white[i]
            gain[i, 0], gain[i, 1], gain[i, 2] = g0 / S, g1 / S, g2 / S
            scale[i] = 1.0 / np.sqrt(S)
            g = (g0, g1, g2)
            for a in range(3):
                for b in range(3):
                    P[a, b] -= g[a] * g[b] / S
        if i + 1 < n and first[i + 1] < 0.5:
            dt = t[i + 1] - t[i]
            e = np.exp(-dt / time)
            A = np.zeros((3, 3))
            A[0, 0], A[0, 1] = 1.0, dt
            A[1, 0], A[1, 1] = -dt * pull[i, 0], 1.0 - dt * pull[i, 1]
            A[2, 2] = e
            B = np.zeros((3, 3))
            for a in range(3):
                for b in range(3):
                    for c in range(3):
                        B[a, b] += A[a, c] * P[c, b]
            for a in range(3):
                for b in range(3):
                    s = 0.0
                    for c in range(3):
                        s += B[a, c] * A[b, c]
                    P[a, b] = s
            P[1, 1] += (push[i] * dt) ** 2
            P[2, 2] += S_b * (1.0 - e * e)
    return gain, scale


@njit
def whiten(
    t: Floats,
    first: Floats,
    pull: Floats,
    stiffness: Floats,
    time: float,
    gain: Floats,
    scale: Floats,
    columns: Floats,
) -> Floats:
    """Return the innovations of ``columns`` (n, m) over their standard deviations."""
    n, m = columns.shape
    out = np.zeros((n, m))
    x = np.zeros((m, 3))
    for i in range(n):
        if first[i] > 0.5:
            x[:, :] = 0.0
        else:
            dt = t[i] - t[i - 1]
            e = np.exp(-dt / time)
            for c in range(m):
                a = pull[i - 1, 0] * x[c, 0] + pull[i - 1, 1] * x[c, 1]
                x[c, 0], x[c, 1] = x[c, 0] + dt * x[c, 1], x[c, 1] - dt * a
                x[c, 2] = e * x[c, 2]
        if scale[i] > 0.0:
            k = stiffness[i]
            for c in range(m):
                v = columns[i, c] - k * x[c, 0] - x[c, 2]
                for j in range(3):
                    x[c, j] += gain[i, j] * v
                out[i, c] = v * scale[i]
    return out
