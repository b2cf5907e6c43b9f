"""Until the touch is felt, the force tells only where the zero of the displacement is not.

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
POORLY_KNOWN = 1.5  # noise of the displacement, std of the zero above which its bound tells anything
ACTIVE = -3.0  # bound in std of the zero below which it cuts nothing off


def detect_touch(m: Floats, force: float, displacement: float) -> None:
    """Cumulative sum of the force over its noise [Page1954]_: whether the contact is felt."""
    if not math.isfinite(force) or m[MODE_BLIND] > 0.5:
        return
    excess = (force - m[Y0 + BIAS]) / math.sqrt(m[SET_R_FORCE] + m[P0 + BIAS * N + BIAS]) - ALLOWED
    counted = min(max(excess, -MOST_EXCESS), MOST_EXCESS)
    m[MODE_TOUCH] = min(max(m[MODE_TOUCH] + counted, 0.0), SUREST)
    if m[MODE_TOUCH] >= TOUCHED:
        m[MODE_FELT] = m[MODE_MET] = 1.0
    elif m[MODE_TOUCH] <= 0.0 and m[MODE_FELT] > 0.5:
        m[MODE_FELT] = 0.0
    if m[MODE_MET] < 0.5 and math.isfinite(displacement):
        exclude_zeros(m, excess, displacement)


def exclude_zeros(m: Floats, excess: float, displacement: float) -> None:
    """Exclude the zeros at which the contact would be felt here: before the first touch, while poorly known.

    Later the tip may be in the air where the memory of a contact has left a dent, and the bound would be a
    maximum over noise.
    """
    std = math.sqrt(m[P0 + OFFSET * N + OFFSET])
    here = min(displacement, m[MOTION_POSITION]) - 2.0 * math.sqrt(m[MOTION_VAR_POSITION])
    if std < POORLY_KNOWN * math.sqrt(m[SET_R_DISPLACEMENT]):
        return
    if excess < 0.0 and here > m[Y0 + OFFSET] + ACTIVE * std and here > m[MODE_FREE_DEPTH]:
        m[MODE_FREE_DEPTH] = max(m[MODE_FREE_DEPTH], here - unseen_depth(m))
    if not m[MODE_FREE_DEPTH] > m[Y0 + OFFSET] + ACTIVE * std:
        m[MODE_ZERO_MEAN], m[MODE_ZERO_VAR] = m[Y0 + OFFSET], std * std
        return
    spread = math.sqrt(m[MODE_ZERO_VAR])
    a = (m[MODE_FREE_DEPTH] - m[MODE_ZERO_MEAN]) / spread
    above = truncated_mean(a)
    move_zero(m, m[MODE_ZERO_MEAN] + spread * above, m[MODE_ZERO_VAR] * (1.0 + a * above - above * above))


def unseen_depth(m: Floats) -> float:
    """Depth [m] up to which the force of a contact is not told from noise, of a tip as soft as it may be."""
    copy_state(m)
    m[TRY0 + DELTA] = 0.0
    threshold = UNSEEN * math.sqrt(m[SET_R_FORCE])
    linearise_at_force(m, TRY0, threshold, 0.0)
    force = contact(m, TRY0)[3]
    softer = 0.0
    for j in range(LEARNED_FROM, M):
        keep = m[TRY0 + j]
        m[TRY0 + j] = keep + SOFTER * math.sqrt(m[P0 + j * N + j])
        change = contact(m, TRY0)[3] / force - 1.0 if force > 0.0 else 0.0
        softer += change * change
        m[TRY0 + j] = keep
    linearise_at_force(m, TRY0, threshold * (1.0 + math.sqrt(softer)), 0.0)
    return max(float(m[TRY0 + DELTA]), 0.0)


def truncated_mean(a: float) -> float:
    """Mean of a standard normal variable above ``a``: ``phi(a) / Q(a)``."""
    if a > 8.0:
        return a + 1.0 / a - 2.0 / (a * a * a)
    return math.exp(-0.5 * a * a) * 0.7978845608028654 / math.erfc(a * 0.7071067811865476)


def move_zero(m: Floats, mean: float, variance: float) -> None:
    """Give the zero this mean and variance; what is correlated with it moves along."""
    before = m[P0 + OFFSET * N + OFFSET]
    if not (before > 0.0 and variance > 0.0):
        return
    shift, change = (mean - m[Y0 + OFFSET]) / before, (variance / before - 1.0) / before
    for i in range(N):
        m[TRY0 + i] = m[P0 + i * N + OFFSET]
    for i in range(N):
        m[Y0 + i] += m[TRY0 + i] * shift
        for j in range(N):
            m[P0 + i * N + j] += m[TRY0 + i] * m[TRY0 + j] * change
