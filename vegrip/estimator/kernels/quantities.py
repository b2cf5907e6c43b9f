"""N, a, k, friction of the state, and how they spread.

Statistical linearisation by central differences: with ``P = L L'`` and the step ``w = sqrt(3)``, the best for
normal states, ``D_j = (q(y + w L_j) - q(y - w L_j)) / (2 w)`` gives the covariance ``D D'``. A derivative at
the mean will not do: where the pressure exponent meets the end of its law it is zero or huge, and says
180 +- 0. Steps along L keep what belongs together: an unknown stiffness scales N_e and its maximum alike.
"""

import math

from vegrip.estimator.kernels.generated import (
    CONSIDER0,
    CONSIDERED,
    CONSIDERED_LOG,
    D0,
    EXOGENOUS0,
    L0,
    LOAD0,
    N_CONSIDERED,
    NS,
    S10,
    TRY0,
    VALUES0,
    Floats,
    M,
    readout,
)
from vegrip.estimator.kernels.roots import WIDE, shifted, square_root
from vegrip.estimator.kernels.sight import sight_slope
from vegrip.estimator.kernels.state import contact, copy_state, put_learned


def quantities(m: Floats, y: int) -> tuple[float, float, float, float]:
    """``N, a, k, friction`` of the state ``y``."""
    x, elastic_force, force, _ = contact(m, y)
    a, k, friction = readout(m, VALUES0, S10, m[y], m[y + 1], EXOGENOUS0, x, elastic_force, force)
    return force, a, k, friction


def spread_quantities(m: Floats) -> tuple[float, float, float, float]:
    """Fill D, 5 x (moving + considered): N, a, k, friction, delta; return the first four at the mean."""
    square_root(m)
    copy_state(m)
    now = quantities(m, TRY0)
    if m[LOAD0 + 1] > 0.5:
        at_constant_force(m)
    for j in range(M):
        shifted(m, j, 1.0)
        up = quantities(m, TRY0)
        shifted(m, j, -1.0)
        note_difference(m, j, up, quantities(m, TRY0), now[2])
        m[D0 + 4 * (M + N_CONSIDERED) + j] = m[L0 + j]
        if j >= 2 + NS and m[LOAD0 + 1] > 0.5:
            m[D0 + j] = 0.0  # exactly; the straight line along which it moved bends
    copy_state(m)
    put_learned(m, TRY0)
    for i in range(N_CONSIDERED):
        at, sd = VALUES0 + CONSIDERED[i], WIDE * math.sqrt(m[CONSIDER0 + i])
        keep = m[at]
        m[at] = keep * math.exp(sd) if CONSIDERED_LOG[i] else keep + sd
        up = quantities(m, TRY0)
        m[at] = keep * math.exp(-sd) if CONSIDERED_LOG[i] else keep - sd
        note_difference(m, M + i, up, quantities(m, TRY0), now[2])
        m[at] = keep
        m[D0 + 4 * (M + N_CONSIDERED) + M + i] = 0.0
    return now


def at_constant_force(m: Floats) -> None:
    """Without a displacement a change of a parameter moves the indentation so that N stays (lose_sight)."""
    for i in range(2 + NS, M):
        slope = sight_slope(m, TRY0, i)
        for j in range(2 + NS, i + 1):
            m[L0 + j] += slope * m[L0 + i * M + j]


def note_difference(
    m: Floats,
    j: int,
    up: tuple[float, float, float, float],
    down: tuple[float, float, float, float],
    exponent: float,
) -> None:
    """Write column ``j`` of D; of the exponent the larger of both sides, it may lie at the end of its law."""
    C = M + N_CONSIDERED
    m[D0 + j] = (up[0] - down[0]) / (2.0 * WIDE)
    m[D0 + C + j] = (up[1] - down[1]) / (2.0 * WIDE)
    rise, fall = up[2] - exponent, exponent - down[2]
    m[D0 + 2 * C + j] = (rise if abs(rise) > abs(fall) else fall) / WIDE
    m[D0 + 3 * C + j] = (up[3] - down[3]) / (2.0 * WIDE)


def spread(m: Floats, a0: float, a1: float, a2: float, a3: float, a4: float) -> float:
    """Standard deviation of ``a0 N + a1 a + a2 k + a3 friction + a4 delta``."""
    C = M + N_CONSIDERED
    total = 0.0
    for j in range(C):
        s = a0 * m[D0 + j] + a1 * m[D0 + C + j] + a2 * m[D0 + 2 * C + j]
        s += a3 * m[D0 + 3 * C + j] + a4 * m[D0 + 4 * C + j]
        total += s * s
    return math.sqrt(total)
