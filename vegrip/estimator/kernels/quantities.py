"""N, a, k, friction of the state, and how they spread.

Statistical linearisation by central differences: with ``P = L L'`` and the step ``w = sqrt(3)``, the best for
normal states, ``D_j = (q(y + w L_j) - q(y - w L_j)) / (2 w)`` gives the covariance ``D D'``. A derivative at
the mean will not do: where the pressure exponent meets the end of its law it is zero or huge, and says
180 +- 0. Steps along L keep what belongs together: an unknown stiffness scales N_e and its maximum alike.

Where a step upwards changes everything by less than 2 %, the step downwards is taken for its mirror image:
what the bend would add to that column is 1 % of it, and half of the work is saved once the state is known.

The limit surface feels k as ``t = 2 / k - 1``, in which it is nearly straight: where a touch is so light that
k may be anything up to the end of its law, its derivative there says nothing, and t is within -1 and 1.

What the model leaves unexplained of the force is no part of the state: it has a column of its own.
"""

import math

from vegrip.estimator.kernels.covariance_root import WIDE, shift_along_root, square_root
from vegrip.estimator.kernels.displacement_loss import slope_at_constant_force
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.load_law import *
from vegrip.estimator.kernels.state import contact, copy_state

Quantities = tuple[float, float, float, float]
"""N [N], a [m], k, friction."""

SLIGHT = 0.02  # relative change below which the law is straight enough


def quantities(m: Floats, y: int) -> Quantities:
    """``N, a, k, friction`` of the state ``y``."""
    x, elastic_force, force, _ = contact(m, y)
    a, k, friction = readout(
        m, VALUES0, TRIAL0, m[y + DELTA], m[y + SPEED], EXOGENOUS0, x, elastic_force, force
    )
    return force, a, k, friction * friction_factor(m, force)


def spread_quantities(m: Floats) -> Quantities:
    """Fill D, 6 x (moving + considered + 1): N, a, k, friction, delta, t; return the first four of now."""
    square_root(m, P0)
    copy_state(m)
    now = quantities(m, TRIED0)
    if m.mode.blind > 0.0:
        at_constant_force(m)
    for j in range(M):
        up = down = now
        if m.l[j * N + j] > 0.0:
            shift_along_root(m, Y0, j, 1.0)
            up = quantities(m, TRIED0)
            if is_slight(now, up) or (j >= LEARNED_FROM and is_unchanged(now, up)):
                down = mirror_step(now, up)
            else:
                shift_along_root(m, Y0, j, -1.0)
                down = quantities(m, TRIED0)
        note_difference(m, j, up, down, now[2])
        m.d_delta[j] = m.l[DELTA * N + j]
        if j >= LEARNED_FROM and m.mode.blind > 0.0:
            m.d_force[j] = 0.0  # exactly; the straight line along which it moved bends
    spread_considered(m, now)
    spread_unexplained(m, now[0])
    return now


def spread_considered(m: Floats, now: Quantities) -> None:
    """Columns of D for parameters that only radius, exponent and friction feel; mu, the last, is a factor.

    Its column is the std of ln mu: bounds are lognormal in it (:func:`.report.upper_gauge`).
    """
    copy_state(m)
    x, elastic_force, force, _ = contact(m, TRIED0)
    factor = friction_factor(m, force)
    m.friction.load = relative_load(force)
    m.consider[CONSIDERED_MU] = friction_variance(m, m.friction.load)
    for i in range(CONSIDERED_MU):
        at, sd = VALUES0 + CONSIDERED[i], WIDE * math.sqrt(m.consider[i])
        keep = m[at]
        m[at] = keep * math.exp(sd) if CONSIDERED_LOG[i] else keep + sd
        a, k, friction = readout(
            m, VALUES0, TRIAL0, m.tried[DELTA], m.tried[SPEED], EXOGENOUS0, x, elastic_force, force
        )
        up = force, a, k, friction * factor
        down = mirror_step(now, up)
        if not is_slight(now, up):
            m[at] = keep * math.exp(-sd) if CONSIDERED_LOG[i] else keep - sd
            a, k, friction = readout(
                m, VALUES0, TRIAL0, m.tried[DELTA], m.tried[SPEED], EXOGENOUS0, x, elastic_force, force
            )
            down = force, a, k, friction * factor
        note_difference(m, M + i, up, down, now[2])
        m[at] = keep
        m.d_delta[M + i] = 0.0
    last = M + CONSIDERED_MU
    m.d_friction[last] = now[3] * math.sqrt(m.consider[CONSIDERED_MU])
    m.d_force[last] = m.d_radius[last] = m.d_exponent[last] = m.d_shape[last] = 0.0
    m.d_delta[last] = 0.0


def spread_unexplained(m: Floats, force: float) -> None:
    """Column of D for what the model leaves unexplained: by so much the ``force`` of a contact may be wrong.

    The filter takes it for noise of the sensor. A tip that comes back from a hard grip does not follow the
    model for seconds; the force would else be stated to a tenth of what it is wrong by.
    """
    last = M + N_CONSIDERED
    m.d_force[last] = math.sqrt(m.mode.tolerated) if force > 0.0 else 0.0
    m.d_radius[last] = m.d_exponent[last] = m.d_shape[last] = 0.0
    m.d_friction[last] = m.d_delta[last] = 0.0


def is_slight(now: Quantities, up: Quantities) -> bool:
    """Whether a step changed little, and k, which may lie at an end of its law, at all."""
    return (
        abs(up[0] - now[0]) <= SLIGHT * now[0]
        and abs(up[1] - now[1]) <= SLIGHT * now[1]
        and 0.0 < abs(up[2] - now[2]) <= SLIGHT * now[2]
        and abs(up[3] - now[3]) <= SLIGHT * now[3]
    )


def is_unchanged(now: Quantities, up: Quantities) -> bool:
    """Whether a step changed nothing: a rate of relaxation is not felt at an instant."""
    return up[0] == now[0] and up[1] == now[1] and up[2] == now[2] and up[3] == now[3]


def mirror_step(now: Quantities, up: Quantities) -> Quantities:
    """Return what a step the other way changes if the law is straight."""
    return 2.0 * now[0] - up[0], 2.0 * now[1] - up[1], 2.0 * now[2] - up[2], 2.0 * now[3] - up[3]


def at_constant_force(m: Floats) -> None:
    """Without a displacement a change of a parameter moves the indentation, so that N stays."""
    for i in range(LEARNED_FROM, M):
        slope = slope_at_constant_force(m, TRIED0, i)
        for j in range(LEARNED_FROM, i + 1):
            m.l[DELTA * N + j] += slope * m.l[i * N + j]


def note_difference(
    m: Floats,
    j: int,
    up: Quantities,
    down: Quantities,
    exponent: float,
) -> None:
    """Write column ``j`` of D; of the exponent the larger of both sides, it may lie at the end of its law."""
    m.d_force[j] = (up[0] - down[0]) / (2.0 * WIDE)
    m.d_radius[j] = (up[1] - down[1]) / (2.0 * WIDE)
    m.d_exponent[j] = larger(up[2] - exponent, exponent - down[2]) / WIDE
    m.d_shape[j] = larger(2.0 / up[2] - 2.0 / exponent, 2.0 / exponent - 2.0 / down[2]) / WIDE
    m.d_friction[j] = (up[3] - down[3]) / (2.0 * WIDE)


def larger(rise: float, fall: float) -> float:
    """Return the one that is larger in magnitude."""
    return rise if abs(rise) > abs(fall) else fall


def combined_std(m: Floats, a0: float, a1: float, a2: float, a3: float, a4: float, a5: float) -> float:
    """Standard deviation of ``a0 N + a1 a + a2 k + a3 friction + a4 delta + a5 t``."""
    total = 0.0
    for j in range(M + N_CONSIDERED + 1):
        s = a0 * m.d_force[j] + a1 * m.d_radius[j] + a2 * m.d_exponent[j]
        s += a3 * m.d_friction[j] + a4 * m.d_delta[j] + a5 * m.d_shape[j]
        total += s * s
    return math.sqrt(total)


def std_with_force(m: Floats, a0: float, a1: float, a3: float, a5: float) -> float:
    """Return what of the deviation of ``a0 N + a1 a + a3 friction + a5 t`` goes with that of N."""
    together, alone = 0.0, 0.0
    for j in range(M + N_CONSIDERED + 1):
        s = a0 * m.d_force[j] + a1 * m.d_radius[j] + a3 * m.d_friction[j] + a5 * m.d_shape[j]
        together += s * m.d_force[j]
        alone += m.d_force[j] * m.d_force[j]
    return abs(together) / math.sqrt(alone) if alone > 0.0 else 0.0
