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

**Force under imposed displacement** is Fung's quasi-linear law [Fung1993]_ as used in Section III of the
paper. Of the general response to a step, eq. (5), it assumes that depth and time are factors, eq. (10):
``Psi(delta, t) = N_e(delta) g(t)``. With a linear elastic response it is linear viscoelasticity, eq. (7).

**Any history**: displacement imposed for a while, load for a while. Where the displacement is imposed and the
force would become a pull, the contact opens and the free surface recovers at zero force; it closes when the
imposed displacement reaches the surface again. Patch and profile stay as they are.

Trap: the compiled functions call each other, so they must stay in one file (:mod:`vegrip.compiled`).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vegrip.compiled import njit
from vegrip.contact.elastic import ElasticLaw
from vegrip.contact.prony import Relaxation
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
            free = drive(z, before, 0.0, dt, c, nu)  # where the surface goes when it is released
            touching = x[i] > free
            x[i] = max(x[i], free)
            force = advance(z, before, x[i], dt, c, nu)
            y[i] = force if touching else 0.0
        before = x[i]


def closed(times: Floats, x: Floats, y: Floats, g: tuple[ArrayLike, ArrayLike]) -> tuple[Floats, Floats]:
    """Complete the histories ``x`` and ``y`` (n,), of which one is NaN at each sample, with ``y >= 0``.

    Where ``x`` is imposed and ``y`` would be negative, ``x`` becomes what makes ``y`` zero: the surface
    that is released. ``g`` are amplitudes and rates. The caller has checked the arguments.
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
    if t.ndim != 1 or x.shape[-1] != len(t):
        raise DomainError(f"times of shape {t.shape} do not fit a history of shape {x.shape}")
    check_times(t)
    if not np.isfinite(x).all():
        raise DomainError("the history has values that are not finite")
    return t, x


def check_times(t: Floats) -> None:
    if not np.isfinite(t).all() or np.any(np.diff(t) < 0):
        raise DomainError("the sample times run backwards or are not finite")


def as_branches(values: ArrayLike) -> Floats:
    """One double per branch, contiguous, as the compiled functions want them."""
    return np.ascontiguousarray(values, dtype=np.float64)


def force_after_step(t: ArrayLike, delta: ArrayLike, law: ElasticLaw, g: Relaxation) -> Floats:
    """Force [N] at ``t`` [s] after a step of indentation to ``delta`` [m], eq. (16): ``N_e(delta) g(t)``."""
    return law.force(delta) * g(t)


def hereditary_force(times: ArrayLike, elastic_force: ArrayLike, g: Relaxation) -> Floats:
    """Force [N] for any history of the elastic force, eqs. (18)-(20); recursive.

    ``times`` (n,) [s], ``elastic_force`` (..., n) [N], result (..., n). Exact when ``N_e`` is linear
    between the samples; equal times are a jump, and a first sample that is not zero is a step.
    """
    return filtered(times, elastic_force, g.amplitudes, g.rates)


def force(times: ArrayLike, delta: ArrayLike, law: ElasticLaw, g: Relaxation) -> Floats:
    """Force [N] for a history of the indentation ``delta`` (..., n) [m], eq. (20); ``delta >= 0``.

    Second order in the step where the elastic law is curved (``N_e`` is taken linear between samples).
    """
    times, delta = sampled(times, delta)
    return hereditary_force(times, law.force(delta), g)


@dataclass(frozen=True)
class ContactHistory:
    """A contact over time; all arrays have the shape of ``times`` (n,)."""

    times: Floats  # [s]
    indentation: Floats  # [m] of the fingertip's surface; in the air, of the dent that is left
    normal_force: Floats  # [N]
    elastic_force: Floats  # [N] N_e(indentation)
    in_contact: NDArray[np.bool_]


def solve(
    times: ArrayLike,
    law: ElasticLaw,
    g: Relaxation,
    *,
    indentation: ArrayLike = np.nan,
    normal_force: ArrayLike = np.nan,
) -> ContactHistory:
    """Solve eq. (20) for what was not imposed.

    At each sample exactly one of ``indentation`` (n,) [m] and ``normal_force`` (n,) [N] is a number, the
    other NaN. A negative indentation is a gap. Exact when the elastic force is linear between the
    samples; equal times are a jump; the instants at which contact is lost and made are resolved to one
    sample.

    Raises:
        DomainError: both or neither imposed, a negative force imposed, times that run backwards.

    """
    t = np.ascontiguousarray(times, dtype=np.float64)
    check_times(t)
    delta, N = _imposed(indentation, t), _imposed(normal_force, t)
    if not np.all(np.isnan(delta) ^ np.isnan(N)):
        raise DomainError("exactly one of indentation and normal force must be imposed at each sample")
    if np.any(N < 0):
        raise DomainError(
            "a contact that does not stick cannot be pulled: the normal force must not be negative"
        )
    elastic = np.where(np.isnan(delta), np.nan, law.force(np.fmax(delta, 0.0)))
    elastic, N = closed(t, elastic, N, (g.amplitudes, g.rates))
    return ContactHistory(t, law.indentation(np.maximum(elastic, 0.0)), N, elastic, N > 0)


def _imposed(values: ArrayLike, t: Floats) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    if np.any(np.isinf(array)):
        raise DomainError("an imposed value is not finite")
    try:
        return np.broadcast_to(array, t.shape)
    except ValueError:
        raise DomainError(f"a history of shape {array.shape} does not fit {len(t)} sample times") from None
