"""The three measurements and their gradients."""

import math

from vegrip.estimator.kernels.gain import scalar_update
from vegrip.estimator.kernels.generated import (
    EXOGENOUS0,
    FELT,
    G0,
    H0,
    H1,
    L0,
    LOAD0,
    NS,
    P0,
    P1,
    S10,
    SET_R_DISPLACEMENT,
    SET_R_FORCE,
    SET_R_RADIUS,
    SET_TIP_RADIUS,
    TRY0,
    VALUES0,
    Y0,
    Floats,
    M,
    N,
    readout,
)
from vegrip.estimator.kernels.roots import WIDE, shifted, square_root
from vegrip.estimator.kernels.state import clear, contact, copy_state, step_of

VAGUE_FORCE = 0.02  # relative std of the predicted force beyond which its slope is taken over all of it


def measure_displacement(m: Floats, value: float) -> bool:
    """``displacement = delta + d0``."""
    clear(m, H0, H1)
    m[H0 + 0] = 1.0
    m[H0 + N - 2] = 1.0
    return scalar_update(m, 0, value - m[Y0] - m[Y0 + N - 2], m[SET_R_DISPLACEMENT])


def force_gradient(m: Floats, y: int) -> float:
    """Fill H with the derivative of the sensed force at ``y``; return that force."""
    clear(m, H0, H1)
    base = contact(m, y)[3]
    for j in range(2 + NS if m[LOAD0 + 1] > 0.5 else M):
        h = step_of(m, y, j)
        if FELT[j] and h > 0.0:
            keep = m[y + j]
            m[y + j] = keep + h
            m[H0 + j] = (contact(m, y)[3] - base) / h
            m[y + j] = keep
    m[H0 + N - 1] = 1.0
    return base


def measure_force(m: Floats, value: float, alone: bool) -> bool:
    """``normal_force = sensed_force + bF``; ``alone``: the displacement is not known, force tells it."""
    y = TRY0
    copy_state(m)
    R = m[SET_R_FORCE]
    bias = m[y + N - 1]
    if alone:
        meet(m, y, value - bias, 3.0 * math.sqrt(R + m[P1 - 1]))
    base = force_gradient(m, y)
    innovation = value - base - bias
    spread = 0.0
    for i in range(M):
        for j in range(M):
            spread += m[H0 + i] * m[P0 + i * N + j] * m[H0 + j]
    if not alone and base > 0.0 and spread > VAGUE_FORCE * VAGUE_FORCE * base * base:
        missed, bend = wide_gradient(m, base)
        return scalar_update(m, 1, innovation - missed, R + bend)
    for j in range(M):
        innovation -= m[H0 + j] * (m[Y0 + j] - m[y + j])
    return scalar_update(m, 1, innovation, R)


def wide_gradient(m: Floats, base: float) -> tuple[float, float]:
    """Fill H with the slope of the force over the whole spread of the state; return mean error and variance.

    Stiffness times indentation bends so much within a wide prior that the slope at its middle claims to
    know more than it does, at every sample anew: central differences along the roots of P instead, with
    what the bend adds to mean and variance (for normal states, to second order).
    """
    square_root(m)
    missed = bend = 0.0
    for j in range(M):
        shifted(m, j, 1.0)
        up = contact(m, TRY0)[3]
        shifted(m, j, -1.0)
        down = contact(m, TRY0)[3]
        m[G0 + j] = (up - down) / (2.0 * WIDE)
        missed += (up + down - 2.0 * base) / (2.0 * WIDE * WIDE)
        bend += (up + down - 2.0 * base) ** 2 * (WIDE * WIDE - 1.0) / (4.0 * WIDE**4)
    for j in range(M - 1, -1, -1):  # L' H = G
        root = m[L0 + j * M + j]
        s = m[G0 + j]
        for i in range(j + 1, M):
            s -= m[L0 + i * M + j] * m[H0 + i]
        m[H0 + j] = s / root if root > 0.0 else 0.0
    return missed, bend


def meet(m: Floats, y: int, force: float, threshold: float) -> None:
    """Move the point of linearisation to the indentation at which the model gives the force.

    At first touch the model's slope is zero and a linearisation there would never leave the air.
    """
    if force < threshold:
        return
    found = contact(m, y)[3]
    if abs(found - force) < threshold:
        return
    low, high = min(m[y], 0.0), m[SET_TIP_RADIUS]
    for _ in range(40):
        m[y] = 0.5 * (low + high)
        if contact(m, y)[3] < force:
            low = m[y]
        else:
            high = m[y]


def measure_radius(m: Floats, value: float) -> bool:
    """``contact_radius = a``."""
    y = TRY0
    copy_state(m)
    clear(m, H0, H1)
    base = radius_of(m, y)
    if base <= 0.0:
        return False
    for j in range(M):
        h = step_of(m, y, j)
        if FELT[j] and h > 0.0:
            keep = m[y + j]
            m[y + j] = keep + h
            m[H0 + j] = (radius_of(m, y) - base) / h
            m[y + j] = keep
    return scalar_update(m, 2, value - base, m[SET_R_RADIUS])


def radius_of(m: Floats, y: int) -> float:
    """Contact radius of the state ``y``."""
    x, elastic_force, force, _ = contact(m, y)
    return readout(m, VALUES0, S10, m[y], m[y + 1], EXOGENOUS0, x, elastic_force, force)[0]
