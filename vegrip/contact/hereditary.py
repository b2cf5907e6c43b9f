"""The one recursion behind every history integral of the paper, in O(branches) per sample.

A history ``x(t)`` that is linear between its samples, filtered by ``1 - sum c_i (1 - exp(-nu_i t))``, is

    y = x - sum_i c_i z_i,      dz_i/dt = nu_i (x - z_i)

where each memory ``z_i`` follows the history with its own delay. Over a step ``D`` the solution is exact,

    z_i+ = E_i z_i + (1 - E_i) x0 + (1 - phi_i)(x1 - x0)
    E_i = exp(-nu_i D),      phi_i = (1 - E_i) / (nu_i D)

With ``x = N_e`` and the ``c_i`` of ``g`` the result ``y`` is the force, eq. (20); with ``x = delta_e``
and the negated ``c_i`` of ``h`` it is the indentation, eq. (43). ``y`` depends on ``x_1`` linearly, so an
imposed ``y`` gives ``x_1`` without iteration. The paper's branch of eq. (20) is ``q_i = x - z_i``;
``z_i`` is the better state, it stays bounded by the history and does not need ``dx/dt``.

Two samples at the same time are a jump between them. Before the first sample ``x = 0``: a first sample
that is not zero is a step.

Trap: the compiled functions call each other, so they must stay in one file (:mod:`vegrip.compiled`).
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from vegrip.compiled import njit
from vegrip.errors import DomainError
from vegrip.types import Floats


@njit
def advance(z: Floats, x0: float, x1: float, dt: float, c: Floats, nu: Floats) -> float:
    """Carry the memories ``z`` over a step from ``x0`` to ``x1`` in ``dt`` [s], in place; return ``y``.

    ``z``, ``c``, ``nu`` have one entry per branch. Compiled; the caller guarantees ``dt >= 0``.
    """
    y = x1
    for i in range(len(z)):
        u = nu[i] * dt
        lost = -math.expm1(-u)
        lag = 1.0 - lost / u if u > 0.0 else 0.0
        z[i] += lost * (x0 - z[i]) + lag * (x1 - x0)
        y -= c[i] * z[i]
    return y


@njit
def drive(z: Floats, x0: float, y1: float, dt: float, c: Floats, nu: Floats) -> float:
    """Return the ``x1`` for which :func:`advance` would return ``y1``; ``z`` is left as it is."""
    known = y1
    gain = 1.0
    for i in range(len(z)):
        u = nu[i] * dt
        lost = -math.expm1(-u)
        lag = 1.0 - lost / u if u > 0.0 else 0.0
        known += c[i] * (z[i] + lost * (x0 - z[i]) - lag * x0)
        gain -= c[i] * lag
    return known / gain


@njit
def _filter(t: Floats, x: Floats, c: Floats, nu: Floats, y: Floats) -> None:
    for row in range(x.shape[0]):
        z = np.zeros(len(c))
        before = 0.0
        for i in range(len(t)):
            y[row, i] = advance(z, before, x[row, i], t[i] - t[max(i - 1, 0)], c, nu)
            before = x[row, i]


@njit
def _close(t: Floats, x: Floats, y: Floats, c: Floats, nu: Floats) -> None:
    z = np.zeros(len(c))
    before = 0.0
    for i in range(len(t)):
        dt = t[i] - t[max(i - 1, 0)]
        if math.isnan(x[i]):
            x[i] = drive(z, before, y[i], dt, c, nu)
            advance(z, before, x[i], dt, c, nu)
        else:
            free = drive(z, before, 0.0, dt, c, nu)  # where the surface goes when it is let go
            touching = x[i] > free
            x[i] = max(x[i], free)
            force = advance(z, before, x[i], dt, c, nu)
            y[i] = force if touching else 0.0
        before = x[i]


def closed(times: Floats, x: Floats, y: Floats, g: tuple[ArrayLike, ArrayLike]) -> tuple[Floats, Floats]:
    """Complete the histories ``x`` and ``y`` (n,), of which one is NaN at each sample, with ``y >= 0``.

    Where ``x`` is imposed and ``y`` would be negative, ``x`` becomes what makes ``y`` zero: the surface
    that is let go. ``g`` are amplitudes and rates. The caller has checked the arguments.
    """
    x, y = x.copy(), y.copy()
    _close(times, x, y, as_branches(g[0]), as_branches(g[1]))
    return x, y


def filtered(times: ArrayLike, x: ArrayLike, c: ArrayLike, nu: ArrayLike) -> Floats:
    """Filter the histories ``x`` (..., n) sampled at ``times`` (n,) [s]; amplitudes and rates (branches,).

    Raises:
        DomainError: times that run backwards, or anything that is not finite.

    """
    t, x = sampled(times, x)
    y = np.empty_like(x)
    rows = (-1, len(t))
    _filter(t, x.reshape(rows), as_branches(c), as_branches(nu), y.reshape(rows))
    return y


def sampled(times: ArrayLike, x: ArrayLike) -> tuple[Floats, Floats]:
    """Check a sampled history: ``times`` (n,) never falling, ``x`` (..., n), all finite."""
    t = np.ascontiguousarray(times, dtype=np.float64)
    x = np.ascontiguousarray(x, dtype=np.float64)
    if t.ndim != 1 or x.ndim == 0 or x.shape[-1] != len(t):
        raise DomainError(f"times of shape {t.shape} do not fit a history of shape {x.shape}")
    check_times(t)
    if not np.isfinite(x).all():
        raise DomainError("the history has values that are not finite")
    return t, x


def check_times(t: Floats) -> None:
    """Raise :class:`DomainError` for sample times that run backwards or are not finite."""
    if not np.isfinite(t).all() or np.any(np.diff(t) < 0):
        raise DomainError("the sample times run backwards or are not finite")


def as_branches(values: ArrayLike) -> Floats:
    """One double per branch, contiguous, as the compiled functions want them."""
    return np.ascontiguousarray(values, dtype=np.float64)
