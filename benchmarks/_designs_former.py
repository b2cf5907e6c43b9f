"""The former design: an extended Kalman filter with a motion model, a gate, and one linearisation.

State: x, speed, z, ln K, p, c1, ln nu, d0, bF. The motion is ``d(speed)/dt = white acceleration`` of the
density ``R^2 agility^3``, adapted by the innovations of the displacement; ``z`` moves along the motion
that the filter expects. The displacement ``d = x + d0 + e`` and the force ``F = N + bF + noise`` are scalar
measurements.

It assumes that drives move smoothly, that an innovation of ten standard deviations is a bad sample, that
slopes at the mean hold over the spread, and that both zeros walk.
"""

import math

import numpy as np

from benchmarks._designs_contact import (
    BIAS,
    DELTA,
    GAP,
    MEMORY,
    SPEED,
    ZERO,
    bound,
    force_slopes,
    memory_after,
    normal_force,
    report,
)
from vegrip.compiled import njit
from vegrip.types import Floats

GATE, HUBER = 100.0, 9.0
RECOVERY = 15  # refusals in a row after which all is widened
AGILITY = 3.0  # [1/s]
ZERO_DRIFT, ZERO_TIME = 0.3, 0.5  # of the noise, [s]
BIAS_DRIFT, BIAS_TIME = 0.5, 2.0


@njit
def predict(y: Floats, P: Floats, F: Floats, dt: float, depth: float, q: float, prior: Floats) -> None:
    """``P = F P F' + Q``, the slopes of the memory by forward differences."""
    n = y.size
    x = y[DELTA] + y[SPEED] * dt
    z = memory_after(y, x, dt, depth, False)
    F[:] = 0.0
    for j in range(n):
        F[j, j] = 1.0
        h = max(1e-3 * math.sqrt(max(P[j, j], 0.0)), 1e-9)
        keep, y[j] = y[j], y[j] + h
        F[MEMORY, j] = (memory_after(y, y[DELTA] + y[SPEED] * dt, dt, depth, False) - z) / h
        y[j] = keep
    F[DELTA, SPEED] = dt
    P[:] = F @ P @ F.T
    P[DELTA, DELTA] += q * dt**3 / 3.0
    P[DELTA, SPEED] += q * dt**2 / 2.0
    P[SPEED, DELTA] += q * dt**2 / 2.0
    P[SPEED, SPEED] += q * dt
    y[DELTA], y[MEMORY] = x, z
    if dt > GAP:
        y[SPEED] = 0.0
        for j in (DELTA, SPEED):
            P[j, :] = 0.0
            P[:, j] = 0.0
            P[j, j] = prior[j]


@njit
def update(y: Floats, P: Floats, H: Floats, innovation: float, R: float) -> float:
    """Take in one scalar measurement unless the gate refuses it; return its normalised square."""
    g = P @ H
    S = H @ g + R
    nis = innovation * innovation / S
    if not nis <= GATE:
        return float(nis)
    weak = S * math.sqrt(nis / HUBER) if nis > HUBER else S
    k = g / weak
    y += k * innovation
    P -= np.outer(k, g) + np.outer(g, k) - S * np.outer(k, k)
    bound(y)
    return float(nis)


@njit
def follow(
    t: Floats,
    d: Floats,
    force: Floats,
    depth: float,
    noise: Floats,
    mean: Floats,
    prior: Floats,
    out: Floats,
) -> None:
    """Run over a recording; ``noise`` [m, N], mean and ``prior`` variance of the state, ``out`` (n, 4)."""
    n = mean.size
    y, P, F, H = mean.copy(), np.diag(prior), np.zeros((n, n)), np.zeros(n)
    y[DELTA] = d[0]
    Rd, Rf = noise[0] ** 2, noise[1] ** 2
    density, restless = (10.0 * depth) ** 2 * AGILITY**3, 1.0
    walk_zero = 2.0 * ZERO_DRIFT**2 * Rd / ZERO_TIME
    walk_bias = 2.0 * BIAS_DRIFT**2 * Rf / BIAS_TIME
    refused = np.zeros(2)
    for i in range(t.size):
        if i > 0:
            dt = t[i] - t[i - 1]
            predict(y, P, F, dt, depth, density * restless, prior)
            P[ZERO, ZERO] = min(P[ZERO, ZERO] + walk_zero * dt, max(prior[ZERO], P[ZERO, ZERO]))
            P[BIAS, BIAS] = min(P[BIAS, BIAS] + walk_bias * dt, max(prior[BIAS], P[BIAS, BIAS]))
        H[:] = 0.0
        H[DELTA] = H[ZERO] = 1.0
        nis = update(y, P, H, d[i] - y[DELTA] - y[ZERO], Rd)
        refused[0] = refused[0] + 1 if nis > GATE else 0.0
        if nis <= GATE:
            restless *= 1.0 + 0.03 * (min(nis, 25.0) - 1.0)
            restless = min(max(restless, 1.0 if nis > HUBER else 1e-4), 100.0)
        if refused[0] >= RECOVERY:
            y[DELTA], y[SPEED] = d[i] - y[ZERO], 0.0
            P += np.diag(prior)
            refused[0] = 0.0
        force_slopes(y, P, depth, False, H)
        H[BIAS] = 1.0
        nis = update(y, P, H, force[i] - normal_force(y, depth, False) - y[BIAS], Rf)
        refused[1] = refused[1] + 1 if nis > GATE else 0.0
        if refused[1] >= RECOVERY:
            P += np.diag(prior)
            P[MEMORY, MEMORY] += (force[i] / 3.0) ** 2
            refused[1] = 0.0
        report(y, P, depth, False, H, out[i])
