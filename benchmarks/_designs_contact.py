"""The contact that all designs share: power law, one relaxing branch, two zeros.

``N = max(N_e - g z, 0)``, ``N_e = K (x / x_ref)^p``, ``dz/dt = nu (s N_e - z)``, ``g = c1 / s``

With ``s = 1`` the memory z is the elastic force that the branch has followed, with ``s = c1`` the force that
has relaxed. The sensors say ``d = x + d0 + e`` and ``F = N + bF + noise``.
"""

import math

from vegrip.compiled import njit
from vegrip.types import Floats

DELTA, MEMORY, LN_K, EXPONENT, C1, LN_NU, ZERO, BIAS, SPEED = range(9)
STATES = 8  # without the speed
LEARNED = slice(LN_K, BIAS + 1)
GAP = 1.0  # [s] after which the memory is taken to have recovered
LOW_EXPONENT, HIGH_EXPONENT, HIGH_C1 = 0.8, 4.0, 0.95


@njit
def elastic(y: Floats, x: float, depth: float) -> float:
    """Return the elastic force [N] at the indentation ``x`` [m]; ``depth`` is x_ref [m]."""
    return float(math.exp(y[LN_K]) * (x / depth) ** y[EXPONENT]) if x > 0.0 else 0.0


@njit
def branch(z: float, before: float, after: float, nu: float, dt: float) -> float:
    """Return z after ``dt`` [s], exact for what it follows being linear in time."""
    h = nu * dt
    lost = -math.expm1(-h)
    phi = lost / h if h > 1e-9 else 1.0 - 0.5 * h
    return z + lost * (before - z) + (1.0 - phi) * (after - before)


@njit
def memory_after(y: Floats, x: float, dt: float, depth: float, as_force: bool) -> float:
    """Return the memory [N] when the indentation has gone from ``y[DELTA]`` to ``x`` within ``dt`` [s].

    A surface that is not touched recovers along N = 0: ``dz/dt = -nu (1 - c1) z``.
    """
    if dt > GAP:
        return 0.0
    c, nu, z = y[C1], math.exp(y[LN_NU]), float(y[MEMORY])
    s = c if as_force else 1.0
    g = 1.0 if as_force else c
    before, after = max(elastic(y, y[DELTA], depth), g * z), elastic(y, x, depth)
    moved = branch(z, s * before, s * after, nu, dt)
    if after >= g * moved:
        return moved
    touching = min(max(before - g * z, 0.0) / max(before - after, 1e-300), 1.0)  # part of the step
    left = branch(z, s * before, s * g * z, nu, touching * dt)
    return float(left * math.exp(-nu * (1.0 - c) * (1.0 - touching) * dt))


@njit
def normal_force(y: Floats, depth: float, as_force: bool) -> float:
    """Return N [N] of the state ``y``."""
    g = 1.0 if as_force else y[C1]
    return max(elastic(y, y[DELTA], depth) - float(g * y[MEMORY]), 0.0)


@njit
def force_slopes(y: Floats, P: Floats, depth: float, as_force: bool, H: Floats) -> None:
    """Write dN/dy into ``H``, by central differences over a hundredth of each standard deviation."""
    H[:] = 0.0
    at = y.copy()
    for j in range(LN_NU + 1):
        h = max(1e-2 * math.sqrt(max(P[j, j], 0.0)), 1e-9)
        at[j] = y[j] + h
        above = normal_force(at, depth, as_force)
        at[j] = y[j] - h
        H[j] = (above - normal_force(at, depth, as_force)) / (2.0 * h)
        at[j] = y[j]


@njit
def report(y: Floats, P: Floats, depth: float, as_force: bool, H: Floats, out: Floats) -> None:
    """Write N, its standard deviation, x, its standard deviation."""
    force_slopes(y, P, depth, as_force, H)
    out[0] = normal_force(y, depth, as_force)
    out[1] = math.sqrt(max(float(H @ P @ H), 0.0))
    out[2], out[3] = y[DELTA], math.sqrt(max(P[DELTA, DELTA], 0.0))


@njit
def bound(y: Floats) -> None:
    """Keep exponent and amplitude where the law makes sense."""
    y[EXPONENT] = min(max(y[EXPONENT], LOW_EXPONENT), HIGH_EXPONENT)
    y[C1] = min(max(y[C1], 0.0), HIGH_C1)
