"""Recursions of the motion, compiled: fixed-interval smoother, and the posterior as a Markov chain.

The smoother is that of [DurbinKoopman2012]_, section 4.4: with innovation v, its variance F and gain K,

    ``r = h v / F + L' r+``,   ``N = h h' / F + L' N+ L``,   ``state | all = state + P r``
    ``a | all = q g' r``,   ``var(a | all) = q - q^2 g' N g``,   ``g = (0, dt)``
"""

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit

Floats = NDArray[np.float64]

WIDE = 1e6  # noise variances: what is known of the position before the first sample


@njit
def smooth(t: Floats, first: Floats, y: Floats, R: float, q: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return position, its variance, squared mean of the acceleration, and ``q g' N g``, each (n,).

    The last two are the terms of the fixed point ``q = a^2 / (q g' N g)`` [Tipping2001]_, eq. (16).
    """
    n = t.shape[0]
    x = np.empty((n, 2))
    P = np.empty((n, 3))
    gain = np.empty((n, 4))  # v / F, 1 / F, K_d, K_v
    for i in range(n):
        if first[i] > 0.5:
            x[i, 0], x[i, 1] = y[i], 0.0
            j = i
            while np.isnan(x[i, 0]) and j + 1 < n:
                j += 1
                x[i, 0] = y[j]
            step = t[i + 1] - t[i] if i + 1 < n else 1.0
            P[i, 0], P[i, 1], P[i, 2] = WIDE * R, 0.0, WIDE * R / (step * step)
        known = not np.isnan(y[i])
        F = P[i, 0] + R
        v = y[i] - x[i, 0] if known else 0.0
        a, b = (P[i, 0] / F, P[i, 1] / F) if known else (0.0, 0.0)
        gain[i, 0], gain[i, 1] = (v / F, 1.0 / F) if known else (0.0, 0.0)
        gain[i, 2], gain[i, 3] = a, b
        if i + 1 < n and first[i + 1] < 0.5:
            dt = t[i + 1] - t[i]
            d0, v0 = x[i, 0] + a * v, x[i, 1] + b * v
            p0, p1, p2 = P[i, 0] - a * P[i, 0], P[i, 1] - a * P[i, 1], P[i, 2] - b * P[i, 1]
            x[i + 1, 0], x[i + 1, 1] = d0 + dt * v0, v0
            P[i + 1, 0] = p0 + 2.0 * dt * p1 + dt * dt * p2
            P[i + 1, 1] = p1 + dt * p2
            P[i + 1, 2] = p2 + q[i] * dt * dt
    position, variance = np.empty(n), np.empty(n)
    jerk, share = np.zeros(n), np.zeros(n)
    r0, r1, n0, n1, n2 = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n - 1, -1, -1):
        if i == n - 1 or first[i + 1] > 0.5:
            r0, r1, n0, n1, n2 = 0.0, 0.0, 0.0, 0.0, 0.0
        else:
            dt = t[i + 1] - t[i]
            jerk[i] = (q[i] * dt * r1) ** 2
            share[i] = q[i] * dt * dt * n2
            n1, n2 = n1 + dt * n0, n2 + 2.0 * dt * n1 + dt * dt * n0  # T' N T
            r1 = r1 + dt * r0
        a, b = gain[i, 2], gain[i, 3]  # then through 1 - K h'
        r0 = gain[i, 0] + (1.0 - a) * r0 - b * r1
        keep = 1.0 - a
        n0, n1 = gain[i, 1] + keep * keep * n0 - 2.0 * keep * b * n1 + b * b * n2, keep * n1 - b * n2
        position[i] = x[i, 0] + P[i, 0] * r0 + P[i, 1] * r1
        spread = P[i, 0] * P[i, 0] * n0 + 2.0 * P[i, 0] * P[i, 1] * n1 + P[i, 1] * P[i, 1] * n2
        variance[i] = P[i, 0] - spread
    return position, variance, jerk, share


@njit
def posterior(t: Floats, first: Floats, y: Floats, R: float, q: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the error of the smoothed motion as a Markov chain: pull (n, 2), push (n,), start (n, 3).

    With the information I that the later samples hold of a state, ``p(state+ | state, later)`` has the noise
    ``g sqrt(c)``, ``c = q / (1 + q g' I g)``, and the transition ``T - c g g' I T``.
    """
    n = t.shape[0]
    pull, push, start = np.zeros((n, 2)), np.zeros(n), np.zeros((n, 3))
    i0, i1, i2 = 0.0, 0.0, 0.0
    for i in range(n - 1, -1, -1):
        if i == n - 1 or first[i + 1] > 0.5:
            i0, i1, i2 = 0.0, 0.0, 0.0
        else:
            dt = t[i + 1] - t[i]
            u0, u1 = i1 * dt, i2 * dt  # I g
            c = q[i] / (1.0 + q[i] * dt * u1)
            push[i] = np.sqrt(c)
            pull[i, 0], pull[i, 1] = c * u0, c * (u0 * dt + u1)
            i0, i1, i2 = i0 - c * u0 * u0, i1 - c * u0 * u1, i2 - c * u1 * u1
            i1, i2 = i1 + dt * i0, i2 + 2.0 * dt * i1 + dt * dt * i0
        if not np.isnan(y[i]):
            i0 += 1.0 / R
        if first[i] > 0.5:
            step = t[i + 1] - t[i] if i + 1 < n else 1.0
            b0, b2 = i0 + 1.0 / (WIDE * R), i2 + step * step / (WIDE * R)
            det = b0 * b2 - i1 * i1
            start[i, 0], start[i, 1], start[i, 2] = b2 / det, -i1 / det, b0 / det
    return pull, push, start
