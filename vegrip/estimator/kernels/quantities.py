"""N, a, k and friction of the state, and their covariance by the delta method."""

import math

from vegrip.estimator.kernels.generated import (
    CONSIDER0,
    CONSIDERED,
    CONSIDERED_LOG,
    EXOGENOUS0,
    G0,
    JAC0,
    LOAD0,
    N_CONSIDERED,
    NS,
    P0,
    S10,
    VALUES0,
    Floats,
    M,
    N,
    readout,
)
from vegrip.estimator.kernels.state import contact, put_learned, step_of


def quantities(m: Floats, y: int) -> tuple[float, float, float, float]:
    """``N, a, k, friction`` of the state ``y``."""
    x, elastic_force, force, _ = contact(m, y)
    a, k, friction = readout(m, VALUES0, S10, m[y], m[y + 1], EXOGENOUS0, x, elastic_force, force)
    return force, a, k, friction


def quantities_jacobian(m: Floats, y: int) -> tuple[float, float, float, float]:
    """Fill JAC, 4 x (moving + considered), at ``y``; return the quantities."""
    C = M + N_CONSIDERED
    q0, q1, q2, q3 = quantities(m, y)
    for j in range(C):
        m[JAC0 + j] = m[JAC0 + C + j] = m[JAC0 + 2 * C + j] = m[JAC0 + 3 * C + j] = 0.0
    for j in range(M):
        h = step_of(m, y, j)
        if h > 0.0 and j != 1:
            keep = m[y + j]
            m[y + j] = keep + h
            r0, r1, r2, r3 = quantities(m, y)
            m[y + j] = keep
            m[JAC0 + j], m[JAC0 + C + j] = (r0 - q0) / h, (r1 - q1) / h
            m[JAC0 + 2 * C + j], m[JAC0 + 3 * C + j] = (r2 - q2) / h, (r3 - q3) / h
    if m[LOAD0 + 1] > 0.5:
        at_constant_force(m, C)
    put_learned(m, y)
    for i in range(N_CONSIDERED):
        at = VALUES0 + CONSIDERED[i]
        keep = m[at]
        h = 1e-4 * math.sqrt(m[CONSIDER0 + i]) + 1e-12
        m[at] = keep * math.exp(h) if CONSIDERED_LOG[i] else keep + h
        r0, r1, r2, r3 = quantities(m, y)
        m[at] = keep
        j = M + i
        m[JAC0 + C + j], m[JAC0 + 2 * C + j], m[JAC0 + 3 * C + j] = (
            (r1 - q1) / h,
            (r2 - q2) / h,
            (r3 - q3) / h,
        )
    return q0, q1, q2, q3


def at_constant_force(m: Floats, C: int) -> None:
    """Without a displacement a change of a parameter moves the indentation so that N stays (lose_sight)."""
    by_depth = m[JAC0]
    if by_depth <= 0.0:
        return
    for j in range(2 + NS, M):
        slope = -m[JAC0 + j] / by_depth
        for q in range(4):
            m[JAC0 + q * C + j] += slope * m[JAC0 + q * C]


def depth_variance(m: Floats) -> float:
    """Variance of the indentation, from JAC where it is not seen."""
    total = float(m[P0])
    by_depth = m[JAC0 + M + N_CONSIDERED]  # of the radius: its columns are at constant force already
    if m[LOAD0 + 1] > 0.5 and by_depth > 0.0:
        C = M + N_CONSIDERED
        for i in range(2 + NS, M):
            for j in range(2 + NS, M):
                both = m[JAC0 + C + i] * m[JAC0 + C + j]
                total += both / (by_depth * by_depth) * m[P0 + i * N + j]
    return float(max(total, 0.0))


def spread(m: Floats, a0: float, a1: float, a2: float, a3: float) -> float:
    """Variance of ``a0 N + a1 a + a2 k + a3 friction`` from JAC and the filter's covariance."""
    C = M + N_CONSIDERED
    for j in range(M):
        m[G0 + j] = (
            a0 * m[JAC0 + j] + a1 * m[JAC0 + C + j] + a2 * m[JAC0 + 2 * C + j] + a3 * m[JAC0 + 3 * C + j]
        )
    total = 0.0
    for i in range(M):
        s = 0.5 * m[P0 + i * N + i] * m[G0 + i]
        for j in range(i + 1, M):
            s += m[P0 + i * N + j] * m[G0 + j]
        total += 2.0 * m[G0 + i] * s
    for i in range(N_CONSIDERED):
        j = M + i
        s = a1 * m[JAC0 + C + j] + a2 * m[JAC0 + 2 * C + j] + a3 * m[JAC0 + 3 * C + j]
        total += s * s * m[CONSIDER0 + i]
    return float(max(total, 0.0))
