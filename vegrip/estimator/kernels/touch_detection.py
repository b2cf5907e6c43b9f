"""Until the touch is felt, the force shows only where the zero of the displacement is not.

No force at a depth means that the contact begins deeper: a bound on the zero, not a measurement of it. What
is known of the zero is then a normal distribution cut off, of which mean and variance are used. Samples that
are regressed one by one make the zero sure without a sample that felt it, and bend stiffness and exponent
until they give no force.
"""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.measure import linearise_at_force
from vegrip.estimator.kernels.state import contact, copy_state

ALLOWED = 1.0  # std of the force by which each sample must exceed, on average, to count as touch
MOST_EXCESS = 3.0  # std that one sample counts at most, so that one alone is not a touch
TOUCHED = 6.0  # sum of the excesses from which the touch is felt
SUREST = 12.0  # sum beyond which nothing is added
SOFTER = 2.0  # std by which its parameters may differ
UNSEEN = 3.0  # std of the force below which a contact is not seen in one sample
POORLY_KNOWN = 1.5  # noise of the displacement, std of the zero above which its bound means anything
ACTIVE = -3.0  # bound in std of the zero below which it cuts nothing off


def detect_touch(m: Floats, force: float, displacement: float) -> None:
    """Cumulative sum of the force over its noise [Page1954]_: whether the contact is felt."""
    if not math.isfinite(force) or m.mode.blind > 0.0:
        return
    excess = (force - m.y[BIAS]) / math.sqrt(m.set.r_force + m.p[BIAS * N + BIAS]) - ALLOWED
    counted = min(max(excess, -MOST_EXCESS), MOST_EXCESS)
    m.mode.touch = min(max(m.mode.touch + counted, 0.0), SUREST)
    if m.mode.touch >= TOUCHED:
        m.mode.felt = m.mode.met = 1.0
    elif m.mode.touch <= 0.0 and m.mode.felt > 0.0:
        m.mode.felt = 0.0
    if m.mode.met == 0.0 and math.isfinite(displacement):
        exclude_zeros(m, excess, displacement)


def exclude_zeros(m: Floats, excess: float, displacement: float) -> None:
    """Exclude the zeros at which the contact would be felt here: before the first touch, while poorly known.

    Later the tip may be in the air where the memory of a contact has left a dent, and the bound would be a
    maximum over noise.
    """
    std = math.sqrt(m.p[OFFSET * N + OFFSET])
    here = min(displacement, m.motion.position) - 2.0 * math.sqrt(m.motion.var_position)
    if std < POORLY_KNOWN * math.sqrt(m.set.r_displacement):
        return
    if excess < 0.0 and here > m.y[OFFSET] + ACTIVE * std and here > m.mode.free_depth:
        m.mode.free_depth = max(m.mode.free_depth, here - unseen_depth(m))
    if not m.mode.free_depth > m.y[OFFSET] + ACTIVE * std:
        m.mode.zero_mean, m.mode.zero_var = m.y[OFFSET], std * std
        return
    spread = math.sqrt(m.mode.zero_var)
    a = (m.mode.free_depth - m.mode.zero_mean) / spread
    above = truncated_mean(a)
    move_zero(m, m.mode.zero_mean + spread * above, m.mode.zero_var * (1.0 + a * above - above * above))


def unseen_depth(m: Floats) -> float:
    """Depth [m] up to which the force of a contact is lost in noise, of a tip as soft as it may be."""
    copy_state(m)
    m.tried[DELTA] = 0.0
    threshold = UNSEEN * math.sqrt(m.set.r_force)
    linearise_at_force(m, TRIED0, threshold, 0.0)
    force = contact(m, TRIED0)[3]
    softer = 0.0
    for j in range(LEARNED_FROM, M):
        keep = m.tried[j]
        m.tried[j] = keep + SOFTER * math.sqrt(m.p[j * N + j])
        change = contact(m, TRIED0)[3] / force - 1.0 if force > 0.0 else 0.0
        softer += change * change
        m.tried[j] = keep
    linearise_at_force(m, TRIED0, threshold * (1.0 + math.sqrt(softer)), 0.0)
    return max(float(m.tried[DELTA]), 0.0)


def truncated_mean(a: float) -> float:
    """Mean of a standard normal variable above ``a``: ``phi(a) / Q(a)``."""
    if a > 8.0:
        return a + 1.0 / a - 2.0 / (a * a * a)
    return math.exp(-0.5 * a * a) * 0.7978845608028654 / math.erfc(a * 0.7071067811865476)


def move_zero(m: Floats, mean: float, variance: float) -> None:
    """Give the zero this mean and variance; what is correlated with it moves along."""
    before = m.p[OFFSET * N + OFFSET]
    if not (before > 0.0 and variance > 0.0):
        return
    shift, change = (mean - m.y[OFFSET]) / before, (variance / before - 1.0) / before
    for i in range(N):
        m.tried[i] = m.p[i * N + OFFSET]
    for i in range(N):
        m.y[i] += m.tried[i] * shift
        for j in range(N):
            m.p[i * N + j] += m.tried[i] * m.tried[j] * change
