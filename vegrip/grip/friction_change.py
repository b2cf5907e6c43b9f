"""What is stated of friction: what is believed of it, and that it may have changed since it was felt.

The belief is of what was felt. Faces get wet without a sign, and dry again without one, until a finger slips
or a load holds. What is stated of ``x = ln mu`` is a mixture of three Gaussians, once the object is known::

    (1 - 2 w) N(m, s^2)  +  w N(m - d, s^2 + r^2)  +  w N(l, q^2)

as believed (m, s); fallen by ``d``, give or take ``r``; back at ``l``, the friction that was believed before
it fell, with the ``q`` of then. ``l`` follows m at once where that rises, and in ``LEVEL_TIME`` where it
falls. Messages carry a value and a standard deviation: those of the Gaussian in ln mu that has the mixture's
quantiles at 2.5 % and 97.5 %. The grip goes on counting on the belief itself.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.grip.late_slip import *

CHANGED = 0.08  # w: chance that friction has fallen, and that it is back
FALL = 0.25  # d, of ln mu
FALL_SPREAD = 0.1  # r
LEVEL_TIME = 20.0  # [s]
TAIL = 0.025
INSIDE = 1.959964  # standard deviations of a Gaussian beyond which TAIL lies
HALVINGS = 25


def begin_changes(g: GraspMemory) -> None:
    """Know of no level yet."""
    for i in range(BELIEF_MOST):
        g.change.level[i], g.change.spread[i] = -math.inf, 0.0


def follow_level(g: GraspMemory, i: int, dt: float) -> None:
    """Note where the friction of finger ``i`` was before it fell; ``dt`` [s] since the last sample."""
    mean, std = believed_mean(g, i), math.sqrt(max(believed_variance(g, i), 0.0))
    if std > g.probe.unknown:
        # what is usual of objects is no level of this one
        g.change.level[i], g.change.spread[i] = -math.inf, 0.0
    elif not g.change.level[i] > mean:
        g.change.level[i], g.change.spread[i] = mean, std
    else:
        g.change.level[i] += (1.0 - math.exp(-dt / LEVEL_TIME)) * (mean - g.change.level[i])


def stated_friction(
    mean: float, std: float, level: float, spread: float, unknown: float
) -> tuple[float, float]:
    """Return mean and std of ln mu that are stated.

    Args:
        mean: of ln mu, as it is believed.
        std: the same.
        level: where it was before it fell, -inf: not known.
        spread: std of that.
        unknown: std from which on nothing is known of the object, so that nothing can have changed.

    """
    if not (0.0 < std <= unknown):
        return mean, std
    if not level > mean or not spread > 0.0:
        level, spread = mean, std
    low = changed_quantile(-INSIDE, TAIL, mean, std, level, spread)
    high = changed_quantile(INSIDE, 1.0 - TAIL, mean, std, level, spread)
    return 0.5 * (low + high), 0.5 * (high - low) / INSIDE


def changed_quantile(
    away: float, chance: float, mean: float, std: float, level: float, spread: float
) -> float:
    """Return where the mixture reaches ``chance``: between the same quantiles of its parts.

    Those lie ``away`` standard deviations from their means.
    """
    fallen = math.sqrt(std * std + FALL_SPREAD * FALL_SPREAD)
    first, second, third = mean + away * std, mean - FALL + away * fallen, level + away * spread
    low, high = min(first, second), max(first, second)
    low, high = min(low, third), max(high, third)
    for _ in range(HALVINGS):
        x = 0.5 * (low + high)
        share = (1.0 - 2.0 * CHANGED) * below((x - mean) / std)
        share += CHANGED * (below((x - mean + FALL) / fallen) + below((x - level) / spread))
        if share < chance:
            low = x
        else:
            high = x
    return 0.5 * (low + high)


def below(z: float) -> float:
    """Return the normal distribution function."""
    return 0.5 * math.erfc(-z * 0.7071067811865476)
