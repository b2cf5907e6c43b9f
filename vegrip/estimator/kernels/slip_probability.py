"""How likely the contact slips at a utilisation, knowing what it has held so far in this loading.

What a load is compared with is the utilisation ``u* = mu`` at which this very contact slips, as far as the
estimator can know it: ``ln u* ~ N(b, s^2)`` from before the loading, s^2 being the variance of friction, its
scatter from one slip to the next, and the error of force, radius and exponent. Having held ``u_h`` cuts off
what lies below, so

    P(slip at u | held u_h) = 1 - Q((ln u - b) / s) / Q((ln u_h - b) / s),    u > u_h,

with Q the upper tail of the normal law: the errors that made u_h large or small make u so too. What is not
sure about u itself (noise of the load, how much the contact will relax) is averaged over with the nodes of
Gauss and Hermite [AbramowitzStegun1964]_.
"""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.load_law import base_variance

NODES = (
    (0.0, 0.5333333333333333),
    (1.355626179974266, 0.2220759220056126),
    (2.8569700138728056, 0.01125741132772068),
)
"""Nodes on one side and weights for the mean over a standard normal variable."""

ROOT_HALF = 0.7071067811865476  # sqrt(1/2)
FARTHEST = 8.0  # standard deviations above b; what holds more shows that b was wrong, not that it slips now


def onset_probability(m: Floats, u: float, unsure: float, load: float) -> float:
    """Probability of slip at utilisation ``u`` (at mu = 1), which is known to ``unsure`` (relative std).

    ``u`` is that at the relative ``load``, what was held is referred to the reference load.
    """
    if u <= 0.0:
        return 0.0
    spread = onset_spread(m, load)
    x = (math.log(u) + m.friction.exponent * load - m.friction.base_ln) / spread
    known = (math.log(m.friction.peak) - m.friction.base_ln) / spread if m.friction.peak > 0.0 else -math.inf
    beyond = max(known - FARTHEST, 0.0)
    x, known = x - beyond, known - beyond
    step = unsure / spread
    held = math.erfc(known * ROOT_HALF)
    total = 0.0
    for node, weight in NODES:
        total += weight * slipped_between(known, held, x + node * step)
        if node > 0.0:
            total += weight * slipped_between(known, held, x - node * step)
    return total


def onset_spread(m: Floats, load: float) -> float:
    """Standard deviation of ``ln u*``: friction before this loading, scatter, error of N, a and k."""
    rest = max(m.report.gauge_rel * m.report.gauge_rel - m.consider[CONSIDERED_MU], 0.0)
    return math.sqrt(base_variance(m, load) + m.friction.scatter_var + min(rest, 1e2))


def slipped_between(known: float, held: float, x: float) -> float:
    """``1 - Q(x) / Q(known)`` for x > known, else 0; ``held`` is ``2 Q(known)``."""
    return 0.0 if x <= known else 1.0 - math.erfc(x * ROOT_HALF) / held
