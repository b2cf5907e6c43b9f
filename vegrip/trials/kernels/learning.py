"""Between a finger's own estimate and the belief of the grasp."""

from vegrip.grip.friction_belief import (
    BELIEF_FINGERS,
    BELIEF_MEAN,
    BELIEF_PRIOR_VAR,
    BELIEF_SINCE,
    BELIEF_VERSION,
    absorb_evidence,
    believed_variance,
    refuse_evidence,
    widen_own,
)
from vegrip.trials.kernels.generated import (
    FRI_BASE_LN,
    FRI_BASE_VAR,
    FRI_LN_MU,
    FRI_VAR,
    G_SEEN,
    G_SITE,
    G_SITE_WEIGHTED,
    Floats,
)


def take_belief(m: Floats, h: Floats, g: Floats, i: int) -> None:
    """Write what the grasp believes of finger ``i`` into its own estimate, if that has changed."""
    if m[FRI_BASE_LN] == m[FRI_LN_MU] and m[FRI_BASE_VAR] == m[FRI_VAR]:
        h[G_SITE + i] = h[G_SITE_WEIGHTED + i] = 0.0
    if g[BELIEF_VERSION] == h[G_SEEN + i]:
        return
    h[G_SEEN + i] = g[BELIEF_VERSION]
    mean, variance = g[BELIEF_MEAN + i], believed_variance(g, i)
    m[FRI_LN_MU] = m[FRI_BASE_LN] = mean
    m[FRI_VAR] = m[FRI_BASE_VAR] = variance
    left = 1.0 / variance - h[G_SITE + i]
    if h[G_SITE + i] != 0.0 and left > 1.0 / g[BELIEF_PRIOR_VAR]:
        m[FRI_BASE_VAR] = 1.0 / left
        m[FRI_BASE_LN] = (mean / variance - h[G_SITE_WEIGHTED + i]) / left


def give_evidence(
    m: Floats, h: Floats, g: Floats, i: int, dt: float, ln: float, variance: float, late: bool
) -> None:
    """Tell the grasp what finger ``i`` has learned since its estimate was ``ln``, ``variance``.

    Of slip that is felt ``late`` it learns by the wrong load, so that is refused.
    """
    g[BELIEF_SINCE] += dt / g[BELIEF_FINGERS]
    if m[FRI_LN_MU] == ln:
        if m[FRI_VAR] > variance + 1e-4:
            widen_own(g, i, m[FRI_VAR])
        return
    if late:
        refuse_evidence(g)
        return
    h[G_SITE + i] += 1.0 / m[FRI_VAR] - 1.0 / variance
    h[G_SITE_WEIGHTED + i] += m[FRI_LN_MU] / m[FRI_VAR] - ln / variance
    absorb_evidence(g, i, ln, variance, m[FRI_LN_MU], m[FRI_VAR])
