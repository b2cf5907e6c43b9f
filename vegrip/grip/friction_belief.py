"""What is believed of the friction between one object and the fingers that hold it, as one joint Gaussian.

For each finger i, ``x_i = ln mu_i``. All fingers touch one object, so most of what is not known is common::

    x ~ N(mean, P),      P = common^2 11' + own^2 I    before anything is felt

Evidence about one finger (a slide, a load that held) is a Gaussian factor on its x_i: a precision and its
product with the mean. Through P it moves what is believed of all the others as well. Evidence counts as it
comes from the finger's own estimate, which has weighed it by its noise and guards it against single samples
and light touches (:mod:`vegrip.estimator.kernels.friction`): the factor is that estimate's posterior over its
prior.

* **Forgetting** widens P with time, most of it for all fingers alike, never beyond the prior.
* **One slip counts for no more** than one at four standard deviations, and a slip of a light touch, which
  tells friction to worse than 0.3 in ln mu, for nothing.
* **Something common happened** (the faces got wet) when a finger slips far below what was believed of it:
  then the common part is widened first, so that one slip lowers what all fingers count on.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory

COMMON_DRIFT = 0.8  # share of the forgetting that is common to all fingers
FAR_BELOW = 2.5  # standard deviations below what was believed, from which a change is taken to be common
FARTHEST_BELOW = 4.0  # standard deviations by which one slip counts at most
LEAST_SLIP_PRECISION = 11.0  # of ln mu (std 0.3); a slip that tells less is one of a light touch
LEAST_PRECISION = 1e-12


def begin_belief(g: GraspMemory, fingers: int, drift: float, shock: float) -> None:
    """Begin with so many fingers of which nothing is expected yet; see :func:`expect_finger`."""
    g.belief.fingers = fingers * 1.0
    g.belief.version = g.belief.since = g.belief.prior_var = 0.0
    g.belief.drift, g.belief.shock = drift, shock
    for i in range(BELIEF_MOST):
        g.belief.mean[i] = g.belief.common[i] = 0.0
        for j in range(BELIEF_MOST):
            g.belief.p[i * BELIEF_MOST + j] = 0.0


def expect_finger(g: GraspMemory, i: int, mean: float, std: float, own: float) -> None:
    """Set the prior of finger ``i``: ``mean`` and ``std`` of ln mu, of which ``own`` is not common to all."""
    g.belief.mean[i] = mean
    g.belief.common[i] = math.sqrt(max(std * std - own * own, 0.0))
    g.belief.prior_var = max(g.belief.prior_var, std * std)
    for j in range(int(g.belief.fingers)):
        shared = g.belief.common[i] * g.belief.common[j]
        g.belief.p[i * BELIEF_MOST + j] = g.belief.p[j * BELIEF_MOST + i] = shared
    g.belief.p[i * BELIEF_MOST + i] = std * std


def forget_evidence(g: GraspMemory, i: int, mean: float) -> None:
    """Believe of finger ``i`` again what was expected: ``mean`` of ln mu, and the spread of the prior."""
    n = int(g.belief.fingers)
    g.belief.mean[i] = mean
    for j in range(n):
        shared = g.belief.common[i] * g.belief.common[j]
        g.belief.p[i * BELIEF_MOST + j] = g.belief.p[j * BELIEF_MOST + i] = shared
    g.belief.p[i * BELIEF_MOST + i] = g.belief.prior_var
    g.belief.version += 1.0


def believed_variance(g: GraspMemory, i: int) -> float:
    """Return the variance of ln mu of finger ``i``."""
    return g.belief.p[i * BELIEF_MOST + i]


def widen_belief(g: GraspMemory) -> None:
    """Forget what the time since the last look asks for, never beyond the prior."""
    grown = g.belief.drift * g.belief.drift * g.belief.since
    g.belief.since = 0.0
    add_common(g, COMMON_DRIFT * grown)
    for i in range(int(g.belief.fingers)):
        at = i * BELIEF_MOST + i
        g.belief.p[at] = max(
            g.belief.p[at], min(g.belief.p[at] + (1.0 - COMMON_DRIFT) * grown, g.belief.prior_var)
        )


def add_common(g: GraspMemory, grown: float) -> None:
    """Add a variance that all fingers share, as far as the widest of them stays below the prior."""
    n = int(g.belief.fingers)
    widest = 0.0
    for i in range(n):
        widest = max(widest, believed_variance(g, i))
    room = min(grown, max(g.belief.prior_var - widest, 0.0))
    for i in range(n):
        for j in range(n):
            g.belief.p[i * BELIEF_MOST + j] += room


def widen_own(g: GraspMemory, i: int, variance: float) -> None:
    """Let finger ``i`` alone have at least ``variance``: it has let go and touched again."""
    at = i * BELIEF_MOST + i
    g.belief.p[at] = max(g.belief.p[at], min(variance, g.belief.prior_var))


def absorb_factor(g: GraspMemory, i: int, precision: float, weighted: float) -> None:
    """Multiply by a Gaussian factor on finger ``i``: its precision, and that times its mean.

    A factor that would leave no variance (a negative precision larger than what is known) is ignored.
    """
    variance = believed_variance(g, i)
    left = 1.0 + precision * variance
    if not (left > LEAST_PRECISION and abs(weighted) < math.inf):
        return
    off = (weighted - precision * g.belief.mean[i]) / left
    shrink = precision / left
    n = int(g.belief.fingers)
    for j in range(n):
        g.belief.mean[j] += g.belief.p[j * BELIEF_MOST + i] * off
    for j in range(n):
        if j != i:
            along = g.belief.p[j * BELIEF_MOST + i]
            for k in range(n):
                if k != i:
                    g.belief.p[j * BELIEF_MOST + k] -= shrink * along * g.belief.p[i * BELIEF_MOST + k]
    for j in range(n):
        if j != i:
            kept = g.belief.p[j * BELIEF_MOST + i] / left
            g.belief.p[j * BELIEF_MOST + i] = g.belief.p[i * BELIEF_MOST + j] = kept
    g.belief.p[i * BELIEF_MOST + i] = variance / left
    g.belief.version += 1.0


def refuse_evidence(g: GraspMemory) -> None:
    """Learn nothing of what a finger's own estimate has learned; it is told again what the grasp believes."""
    g.belief.version += 1.0


def absorb_evidence(
    g: GraspMemory, i: int, ln_before: float, var_before: float, ln_after: float, var_after: float
) -> None:
    """Take in what finger ``i`` learned: mean and variance of ln mu in its own estimate, before and after."""
    if not (var_before > 0.0 and var_after > 0.0):
        return
    precision = 1.0 / var_after - 1.0 / var_before
    weighted = ln_after / var_after - ln_before / var_before
    widen_belief(g)
    if precision > 0.0:
        off = weighted / precision - g.belief.mean[i]
        if off < 0.0 and precision < LEAST_SLIP_PRECISION:
            refuse_evidence(g)
            return
        expected = math.sqrt(believed_variance(g, i) + 1.0 / precision)
        if off < -FAR_BELOW * expected:
            add_common(g, g.belief.shock * g.belief.shock)
        weighted = precision * (g.belief.mean[i] + max(off, -FARTHEST_BELOW * expected))
    absorb_factor(g, i, precision, weighted)
