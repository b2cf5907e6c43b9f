"""How sure every finger must be, so that the whole grasp is as sure as wanted.

Whether finger i slips depends on an error ``sqrt(rho) z + sqrt(1 - rho) z_i`` in units of its standard
deviation: z is common to all fingers (they touch one object, whose friction is not known), z_i is its own.
If each keeps its load with the quantile q, none of n slips with the probability

    P(q) = E_z[ Phi((q + sqrt(rho) z) / sqrt(1 - rho))^n ] ,

which grows with q. ``rho = 1`` gives the confidence of a single finger, ``rho = 0`` its n-th root
[Sidak1967]_. Where the fingers share what they learn of friction, rho is that of their joint belief before
anything is felt (:func:`shared_part`), else ``FINGER_CORRELATION``.
"""

from functools import cache

import numpy as np
from scipy.special import ndtr, ndtri

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(96)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
FINGER_CORRELATION = 0.9
"""Of the errors of fingers that do not share what they learn of friction [-]: they hold one object."""
SAME_DIGITS = 12  # to which linear algebra of every processor agrees; commands must not depend on it
_ALL = 1.0 - 1e-6  # correlation from which on the errors count as one


def shared_part(std: float, own: float) -> float:
    """Return the correlation of ln mu of two fingers on one object.

    Args:
        std: of ln mu of each.
        own: the part of it that is not common to all.

    """
    return 1.0 - min(own / std, 1.0) ** 2 if std > 0.0 else 0.0


def joint_confidence(quantile: float, fingers: int, correlation: float) -> float:
    """Return the probability that no finger slips, when each keeps its load at ``quantile``."""
    if correlation >= _ALL:
        return float(ndtr(quantile))
    each = ndtr((quantile + np.sqrt(correlation) * _NODES) / np.sqrt(1.0 - correlation))
    return float(_WEIGHTS @ each**fingers)


@cache
def each_confidence(probability: float, fingers: int, correlation: float) -> float:
    """Return the one-sided confidence that each finger needs; asked at every state, for few arguments.

    Args:
        probability: that no finger slips, in (0, 1).
        fingers: that share the grasp.
        correlation: of their errors, 0 .. 1.

    """
    if fingers <= 1 or correlation >= _ALL:
        return probability
    root: float = probability ** (1.0 / fingers)
    alone, independent = float(ndtri(probability)), float(ndtri(root))

    from scipy.optimize import brentq  # noqa: PLC0415 (slow to import, and for one finger not needed)

    def missing(quantile: float) -> float:
        return joint_confidence(quantile, fingers, correlation) - probability

    if missing(alone) >= 0.0:
        return probability
    if missing(independent) <= 0.0:
        return round(root, SAME_DIGITS)
    return round(float(ndtr(brentq(missing, alone, independent, xtol=1e-14))), SAME_DIGITS)
