"""Prediction: state and covariance through one time step."""

import math

from vegrip.estimator.kernels.generated import (
    B0,
    DRIFT0,
    F0,
    KEPT,
    LOAD0,
    MOTION0,
    NS,
    P0,
    PRIOR0,
    S00,
    S10,
    SET_ACCELERATION,
    SET_R_DISPLACEMENT,
    TRY0,
    Y0,
    Floats,
    M,
    N,
)
from vegrip.estimator.kernels.state import copy_state, leash, propagate, step_of


def predict(m: Floats, dt: float, rho: float) -> None:
    """Move state and covariance by ``dt`` [s]; ``rho`` is what is left of the speed (1 = all)."""
    effects_ahead(m, dt)
    move_covariance(m, dt, rho)
    m[Y0] += m[Y0 + 1] * dt
    m[Y0 + 1] *= rho
    for i in range(NS):
        m[Y0 + 2 + i] = m[S00 + i]
    disturb(m, dt)


def effects_ahead(m: Floats, dt: float) -> None:
    """Put the effect states after ``dt`` into S0 and their derivatives into F, (NS, M)."""
    if NS == 0:
        return
    copy_state(m)
    propagate(m, TRY0, dt, S00)
    for j in range(M):
        known = j >= 2 + NS and m[LOAD0 + 1] > 0.5  # parameters without a displacement, see sight.py
        h = 0.0 if known else step_of(m, Y0, j)
        if h > 0.0:
            m[TRY0 + j] = m[Y0 + j] + h
            propagate(m, TRY0, dt, S10)
            m[TRY0 + j] = m[Y0 + j]
        for i in range(NS):
            m[F0 + i * M + j] = (m[S10 + i] - m[S00 + i]) / h if h > 0.0 else 0.0
    hold_extremes(m)


def hold_extremes(m: Floats) -> None:
    """The maximum of noisy values is not the noisy value of the maximum: discount new extremes by the noise.

    The noise is what the indentation does from sample to sample, without its slow error: that of the zero
    d0, or of the force's bias bF where force alone tells it. Of the maximum of some hundred looks, 2.5
    standard deviations are noise.
    """
    seen = m[LOAD0 + 1] < 0.5
    slow = N - 2 if seen else N - 1
    variance = m[P0] - m[P0 + slow] * m[P0 + slow] / max(m[P0 + slow * N + slow], 1e-300)
    quick = math.sqrt(max(min(variance, m[SET_R_DISPLACEMENT]) if seen else variance, 0.0))
    for i in range(NS):
        if KEPT[2 + i]:
            old, noise = m[Y0 + 2 + i], 2.5 * abs(m[F0 + i * M]) * quick
            if m[S00 + i] > old:
                m[S00 + i] = max(old, m[S00 + i] - noise)
            else:
                m[S00 + i] = min(old, m[S00 + i] + noise)


def move_covariance(m: Floats, dt: float, rho: float) -> None:
    """``P = F P F'``; only the rows of delta, speed and effects move, the others are the identity's."""
    for c in range(N):  # B = F P, the rows that move
        m[B0 + c] = m[P0 + c] + dt * m[P0 + N + c]
        m[B0 + N + c] = rho * m[P0 + N + c]
    for i in range(NS):
        for c in range(N):
            s = 0.0
            for j in range(M):
                s += m[F0 + i * M + j] * m[P0 + j * N + c]
            m[B0 + (2 + i) * N + c] = s
    for a in range(2 + NS):
        for c in range(2 + NS, N):
            m[P0 + a * N + c] = m[B0 + a * N + c]
            m[P0 + c * N + a] = m[B0 + a * N + c]
    m[P0] = m[B0] + dt * m[B0 + 1]
    m[P0 + 1] = m[P0 + N] = rho * m[B0 + 1]
    m[P0 + N + 1] = rho * m[B0 + N + 1]
    for a in range(2 + NS):
        for i in range(NS):
            s = 0.0
            for j in range(M):
                s += m[F0 + i * M + j] * m[B0 + a * N + j]
            m[P0 + a * N + 2 + i] = s
            m[P0 + (2 + i) * N + a] = s


def disturb(m: Floats, dt: float) -> None:
    """Add the process noise: white acceleration, random walks; nothing gets less certain than at first."""
    q = m[SET_ACCELERATION] * m[MOTION0]
    m[P0] += q * dt * dt * dt / 3.0
    m[P0 + 1] += q * dt * dt / 2.0
    m[P0 + N] = m[P0 + 1]
    m[P0 + N + 1] += q * dt
    for j in range(2, N):
        m[P0 + j * N + j] += m[DRIFT0 + j] * dt
    for j in range(N):
        if j < 2 or j >= 2 + NS:
            leash(m, j, m[PRIOR0 + j])
