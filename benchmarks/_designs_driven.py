"""Two designs in which the measured displacement drives the contact: no motion model, no gate.

State: x, z, ln K, p, c1, ln nu, d0, bF. At every sample ``x = d - d0 - e`` with an error e drawn anew, ``z``
follows from the old and the new x, and the force is the one measurement, ``F = N + bF + noise``.

* :func:`follow_tangent`: extended Kalman filter, slopes at the mean, the update iterated. It
  assumes that the laws are straight over the spread of what is not known.
* :func:`follow_regression`: iterated posterior linearisation, slopes and bends by statistical linear
  regression along the roots of the covariance [SarkkaSvensson2023]_, ``z`` written as a force. It assumes a
  Gaussian belief, and that the bends of successive steps are independent.

Both believe every sample.
"""

import math

import numpy as np

from benchmarks._designs_contact import (
    BIAS,
    DELTA,
    GAP,
    MEMORY,
    ZERO,
    bound,
    force_slopes,
    memory_after,
    normal_force,
    report,
)
from vegrip.compiled import njit
from vegrip.types import Floats

ITERATIONS = 2
WIDE = math.sqrt(3.0)  # of the regression's points, in standard deviations
ZERO_DRIFT, ZERO_TIME = 0.1, 0.5  # of the noise, [s]
BIAS_DRIFT, BIAS_TIME = 0.1, 2.0


@njit
def walk(P: Floats, noise: Floats, dt: float) -> None:
    """Let both zeros walk."""
    P[ZERO, ZERO] += 2.0 * (ZERO_DRIFT * noise[0]) ** 2 / ZERO_TIME * dt
    P[BIAS, BIAS] += 2.0 * (BIAS_DRIFT * noise[1]) ** 2 / BIAS_TIME * dt


@njit
def add_error(P: Floats, slope: float, error: float) -> None:
    """Add the present error of the displacement, which the memory feels by ``slope`` [N/m]."""
    P[DELTA, DELTA] += error**2
    P[DELTA, MEMORY] += slope * error**2
    P[MEMORY, DELTA] += slope * error**2
    P[MEMORY, MEMORY] += (slope * error) ** 2


@njit
def begin(d: float, mean: Floats, prior: Floats, error: float) -> tuple[Floats, Floats]:
    """Return state and covariance in the air, the indentation as the first displacement says."""
    y, P = mean.copy(), np.diag(prior)
    y[DELTA], P[MEMORY, MEMORY] = d, 0.0
    P[DELTA, DELTA] = error**2 + P[ZERO, ZERO]
    P[DELTA, ZERO] = P[ZERO, DELTA] = -P[ZERO, ZERO]
    return y, P


@njit
def predict_tangent(y: Floats, P: Floats, d: float, dt: float, depth: float, error: float) -> None:
    """Move to the displacement ``d``, slopes of the memory at the mean."""
    n = y.size
    x = d - y[ZERO]
    z = memory_after(y, x, dt, depth, False)
    A = np.eye(n)
    A[DELTA, :] = 0.0
    A[DELTA, ZERO] = -1.0
    for j in range(n):
        h = max(1e-2 * math.sqrt(max(P[j, j], 0.0)), 1e-9)
        keep, y[j] = y[j], y[j] + h
        A[MEMORY, j] = (memory_after(y, d - y[ZERO], dt, depth, False) - z) / h
        y[j] = keep
    h = 1e-2 * error
    slope = (memory_after(y, x + h, dt, depth, False) - z) / h
    P[:] = A @ P @ A.T
    add_error(P, slope, error)
    y[DELTA], y[MEMORY] = x, z


@njit
def follow_tangent(
    t: Floats,
    d: Floats,
    force: Floats,
    depth: float,
    noise: Floats,
    mean: Floats,
    prior: Floats,
    out: Floats,
) -> None:
    """Run the extended filter over a recording; ``noise`` [m, N], ``prior`` variances, ``out`` (n, 4)."""
    y, P = begin(d[0], mean, prior, noise[0])
    H, g, S = np.zeros(y.size), np.zeros(y.size), 1.0
    for i in range(t.size):
        if i > 0:
            walk(P, noise, t[i] - t[i - 1])
            predict_tangent(y, P, d[i], t[i] - t[i - 1], depth, noise[0])
        at = y.copy()
        for _ in range(ITERATIONS):
            force_slopes(at, P, depth, False, H)
            H[BIAS] = 1.0
            g = P @ H
            S = H @ g + noise[1] ** 2
            off = force[i] - normal_force(at, depth, False) - at[BIAS] - H @ (y - at)
            at = y + g / S * off
            bound(at)
        y = at
        P -= np.outer(g, g) / S
        report(y, P, depth, False, H, out[i])


@njit
def square_root(P: Floats, L: Floats) -> None:
    """Cholesky root of a covariance that may be singular."""
    L[:] = 0.0
    for j in range(P.shape[0]):
        pivot = P[j, j]
        for c in range(j):
            pivot -= L[j, c] ** 2
        if pivot > 1e-12 * P[j, j] and pivot > 0.0:
            L[j, j] = math.sqrt(pivot)
            for i in range(j + 1, P.shape[0]):
                s = P[i, j]
                for c in range(j):
                    s -= L[i, c] * L[j, c]
                L[i, j] = s / L[j, j]


@njit
def predict_regression(
    y: Floats, P: Floats, L: Floats, d: float, dt: float, depth: float, error: float
) -> None:
    """Move to the displacement ``d``, slopes and bends of the memory along the roots of P."""
    n = y.size
    x = d - y[ZERO]
    z = memory_after(y, x, dt, depth, True)
    square_root(P, L)
    row, shift, bend = np.zeros(n), 0.0, 0.0
    for j in range(n):
        up, down = y + WIDE * L[:, j], y - WIDE * L[:, j]
        above = memory_after(up, d - up[ZERO], dt, depth, True)
        below = memory_after(down, d - down[ZERO], dt, depth, True)
        row[j] = (above - below) / (2.0 * WIDE)
        shift += (above + below - 2.0 * z) / (2.0 * WIDE**2)
        bend += (above + below - 2.0 * z) ** 2 * (WIDE**2 - 1.0) / (4.0 * WIDE**4)
    h = 1e-2 * error
    slope = (memory_after(y, x + h, dt, depth, True) - z) / h
    L[DELTA, :] = -L[ZERO, :]
    L[MEMORY, :] = row
    P[:] = L @ L.T
    add_error(P, slope, error)
    P[MEMORY, MEMORY] += bend
    y[DELTA], y[MEMORY] = x, z + shift


@njit
def regress_force(at: Floats, L: Floats, depth: float, H: Floats) -> tuple[float, float]:
    """Write the slopes of F over the spread ``L L'`` about ``at``; return the mean of F and its bend."""
    n = at.size
    middle = normal_force(at, depth, True)
    along, shift, bend = np.zeros(n), 0.0, 0.0
    for j in range(n):
        above = normal_force(at + WIDE * L[:, j], depth, True)
        below = normal_force(at - WIDE * L[:, j], depth, True)
        along[j] = (above - below) / (2.0 * WIDE)
        shift += (above + below - 2.0 * middle) / (2.0 * WIDE**2)
        bend += (above + below - 2.0 * middle) ** 2 * (WIDE**2 - 1.0) / (4.0 * WIDE**4)
    for j in range(n - 1, -1, -1):  # L' H = along
        s = along[j]
        for i in range(j + 1, n):
            s -= L[i, j] * H[i]
        H[j] = s / L[j, j] if L[j, j] > 0.0 else 0.0
    H[BIAS] = 1.0
    return middle + shift + at[BIAS], bend


@njit
def follow_regression(
    t: Floats,
    d: Floats,
    force: Floats,
    depth: float,
    noise: Floats,
    mean: Floats,
    prior: Floats,
    out: Floats,
) -> None:
    """Run the iterated regression over a recording; arguments as of :func:`follow_tangent`."""
    y, P = begin(d[0], mean, prior, noise[0])
    n = y.size
    H, L = np.zeros(n), np.zeros((n, n))
    for i in range(t.size):
        if i > 0:
            dt = t[i] - t[i - 1]
            walk(P, noise, dt)
            predict_regression(y, P, L, d[i], dt, depth, noise[0])
            if dt > GAP:
                P[MEMORY, :] = 0.0
                P[:, MEMORY] = 0.0
        at, spread = y.copy(), P.copy()
        for _ in range(ITERATIONS):
            square_root(spread, L)
            expected, bend = regress_force(at, L, depth, H)
            g = P @ H
            S = H @ g + noise[1] ** 2 + bend
            at = y + g / S * (force[i] - expected - H @ (y - at))
            bound(at)
            spread = P - np.outer(g, g) / S
        y, P = at, spread
        report(y, P, depth, True, H, out[i])
