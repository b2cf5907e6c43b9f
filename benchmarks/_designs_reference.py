"""The best possible: what a fit of all data up to each look knows, with the truth and with the prior.

Neither runs in real time. Both take the memory as the corrected (or true) displacement makes it, without an
error of its own.
"""

import math

import numpy as np

from benchmarks._designs_contact import (
    BIAS,
    C1,
    DELTA,
    EXPONENT,
    HIGH_C1,
    HIGH_EXPONENT,
    LEARNED,
    LN_K,
    LOW_EXPONENT,
    MEMORY,
    STATES,
    ZERO,
    elastic,
    memory_after,
    normal_force,
)
from vegrip.compiled import njit
from vegrip.types import Floats

UNKNOWNS = BIAS - LN_K + 2  # learned parameters, zeros, the present error
STEPS = 15  # of Gauss and Newton at most
HALVINGS = 5  # of a step that does not help


@njit
def trace(u: Floats, t: Floats, d: Floats, depth: float, force: Floats, slope: Floats, z: Floats) -> None:
    """Write the expected force [N], its slope over the displacement [N/m], and the memory [N].

    ``u`` are parameters, zeros, and the error e of the last displacement.
    """
    y = np.zeros(STATES)
    y[LEARNED] = u[:-1]
    last = t.size - 1
    h = 1e-3 * depth
    for i in range(t.size):
        x = d[i] - y[ZERO] - (u[-1] if i == last else 0.0)
        dt = t[i] - t[i - 1] if i > 0 else 2.0
        after = memory_after(y, x, dt, depth, False)
        beyond = memory_after(y, x + h, dt, depth, False)
        y[DELTA], y[MEMORY] = x, after
        N = normal_force(y, depth, False)
        force[i], z[i] = N + y[BIAS], y[C1] * after
        stiff = (elastic(y, x + h, depth) - elastic(y, x, depth) - y[C1] * (beyond - after)) / h
        slope[i] = stiff if N > 0.0 else 0.0


@njit
def correct(
    u: Floats, t: Floats, d: Floats, depth: float, force: Floats, noise: Floats, corrected: Floats
) -> None:
    """Write the displacements [m] without their most probable errors; that of the last is ``u[-1]``.

    ``e = argmin ((F - N(d - d0 - e) - bF) / s_F)^2 + (e / s_d)^2`` at each sample. A slope at the
    displacement as measured is correlated with the residual, which made exponent and stiffness come out low.
    """
    y = np.zeros(STATES)
    y[LEARNED] = u[:-1]
    last, h = t.size - 1, 1e-3 * depth
    for i in range(t.size):
        measured = d[i] - y[ZERO]
        dt = t[i] - t[i - 1] if i > 0 else 2.0
        before = y[DELTA]
        x = measured
        for _ in range(0 if i == last else 3):
            y[DELTA] = before
            z = memory_after(y, x, dt, depth, False)
            N = elastic(y, x, depth) - y[C1] * z
            s = (elastic(y, x + h, depth) - elastic(y, x, depth)) / h if N > 0.0 else 0.0
            off = force[i] - y[BIAS] - max(N, 0.0) - s * (measured - x)
            x = measured + noise[0] ** 2 * s / (noise[1] ** 2 + (s * noise[0]) ** 2) * off
        corrected[i] = x + y[ZERO]
        y[DELTA] = before
        after = memory_after(y, x, dt, depth, False)
        y[DELTA], y[MEMORY] = x, after


def traced(u: Floats, t: Floats, d: Floats, depth: float) -> tuple[Floats, Floats, Floats]:
    """Return the expected force, its slope, and the memory, each (n,)."""
    found = np.empty((3, t.size))
    trace(u, t, d, depth, found[0], found[1], found[2])
    return found[0], found[1], found[2]


def with_the_truth(
    t: Floats, d: Floats, force: Floats, depth: float, noise: Floats, true: Floats, path: Floats
) -> Floats:
    """Return N, std, x, std, (n, 4), when parameters, zeros and past are known and only e is not.

    Minimises ``((d - x) / s_d)^2 + ((F - N(x)) / s_F)^2`` over x, the memory being that of the true path.
    """
    u = np.concatenate([true, np.zeros(3)])
    z = traced(u, t, path, depth)[2]
    K, p = math.exp(true[0]), true[1]
    x = d.copy()
    for _ in range(5):
        N = np.maximum(K * (np.maximum(x, 0.0) / depth) ** p - z, 0.0)
        s = np.where(N > 0.0, K * p / depth * (np.maximum(x, 0.0) / depth) ** (p - 1.0), 0.0)
        known = 1.0 / noise[0] ** 2 + (s / noise[1]) ** 2
        x = x + ((d - x) / noise[0] ** 2 + s * (force - N) / noise[1] ** 2) / known
    sd = 1.0 / np.sqrt(known)
    N = np.maximum(K * (np.maximum(x, 0.0) / depth) ** p - z, 0.0)
    return np.stack([N, s * sd, x, sd], axis=1)


def with_the_prior(
    t: Floats,
    d: Floats,
    force: Floats,
    depth: float,
    noise: Floats,
    mean: Floats,
    prior: Floats,
    looks: list[int],
) -> Floats:
    """Return N, std, x, std, (looks, 4): at each look the most probable parameters, zeros and present error.

    Gauss-Newton over all forces and displacements up to the look. The errors e of the displacements before it
    are eliminated sample by sample, which leaves residuals of the variance ``s_F^2 + (N' s_d)^2``; that at
    the look is an unknown of its own. The interval is Laplace's.
    """
    centre = np.append(mean[LEARNED], 0.0)
    weight = 1.0 / np.append(prior[LEARNED], noise[0] ** 2)
    u, rows = centre.copy(), []
    for look in looks:
        upto = slice(0, look + 1)
        u[-1] = 0.0
        u, A, J, expected = most_probable(u, t[upto], d[upto], force[upto], depth, noise, centre, weight)
        cov = np.linalg.inv(A)
        to_N, to_x = J[-1].copy(), np.zeros(UNKNOWNS)
        to_N[BIAS - LN_K] = 0.0
        to_x[ZERO - LN_K] = to_x[-1] = -1.0
        x = d[look] - u[ZERO - LN_K] - u[-1]
        N = expected[-1] - u[BIAS - LN_K]
        rows.append((N, math.sqrt(to_N @ cov @ to_N), x, math.sqrt(to_x @ cov @ to_x)))
    return np.array(rows)


def most_probable(
    u: Floats,
    t: Floats,
    d: Floats,
    force: Floats,
    depth: float,
    noise: Floats,
    centre: Floats,
    weight: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the most probable unknowns, their information, the slopes (n, unknowns) and forces there."""
    free, path = np.append(np.ones(t.size - 1), 0.0), np.empty_like(d)

    def cost(at: Floats) -> float:
        correct(at, t, d, depth, force, noise, path)
        off, e = force - traced(at, t, path, depth)[0], d - path
        return float(
            off @ off / noise[1] ** 2 + e @ e / noise[0] ** 2 + (at - centre) @ (weight * (at - centre))
        )

    for _ in range(STEPS):
        now = cost(u)
        expected, slope, _ = traced(u, t, path, depth)
        w = 1.0 / (noise[1] ** 2 + free * (slope * noise[0]) ** 2)
        J = slopes(u, t, path, depth, weight)
        A = (J * w[:, None]).T @ J + np.diag(weight)
        off = force - expected - slope * (d - path)
        step = np.linalg.solve(A, J.T @ (w * off) + weight * (centre - u))
        if step @ A @ step < 1e-3:
            break
        step /= max(1.0, float(np.max(np.abs(step) * np.sqrt(weight))))  # by one width of the prior at most
        new = within_bounds(u + step)
        for _ in range(HALVINGS):
            if cost(new) < now:
                break
            step *= 0.5
            new = within_bounds(u + step)
        else:
            break  # as good as it gets
        u = new
    return u, A, J, expected


def within_bounds(u: Floats) -> Floats:
    """Return the unknowns with exponent and amplitude where the law makes sense."""
    u = u.copy()
    u[EXPONENT - LN_K] = min(max(u[EXPONENT - LN_K], LOW_EXPONENT), HIGH_EXPONENT)
    u[C1 - LN_K] = min(max(u[C1 - LN_K], 1e-3), HIGH_C1)
    return u


def slopes(u: Floats, t: Floats, d: Floats, depth: float, weight: Floats) -> Floats:
    """Return the change of the forces with each unknown, by central differences."""
    J = np.empty((t.size, UNKNOWNS))
    for j in range(UNKNOWNS):
        h = np.zeros(UNKNOWNS)
        h[j] = 1e-3 / math.sqrt(weight[j])
        J[:, j] = (traced(u + h, t, d, depth)[0] - traced(u - h, t, d, depth)[0]) / (2.0 * h[j])
    return J
