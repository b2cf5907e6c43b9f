"""Geometry of a hemispherical fingertip on a flat: indentation, contact radius, depression [TiezziKao2007]_.

Symbols: ``R`` [m] radius of the fingertip, ``delta`` [m] indentation at the centre of the patch, ``a`` [m]
radius of the patch, ``r`` [m] distance from the centre of the patch.
"""

import numpy as np
from numpy.typing import ArrayLike

from vegrip.contact.domain import not_negative, positive
from vegrip.errors import DomainError
from vegrip.types import Floats

HERTZ = 1.0
GEOMETRIC = 2.0


def contact_radius(delta: ArrayLike, R: ArrayLike) -> Floats:
    """Radius of the circle in which the undeformed sphere cuts the flat [m], eq. (1).

        R^2 = (R - delta)^2 + a^2

    Assumes that the surface does not bulge at the edge. ``0 <= delta <= R``, else :class:`DomainError`.
    """
    R, delta = _sphere(R, delta)
    return np.sqrt(delta * (2 * R - delta))


def indentation(a: ArrayLike, R: ArrayLike) -> Floats:
    """Indentation at which eq. (1) gives the contact radius ``a`` [m]; ``0 <= a <= R``."""
    R, a = positive("fingertip radius", R, "m"), not_negative("contact radius", a, "m")
    if np.any(a > R):
        raise DomainError("the contact radius is larger than the fingertip")
    return a**2 / (R + np.sqrt(R**2 - a**2))  # = R - sqrt(R^2 - a^2), without the cancellation


def local_depression(r: ArrayLike, delta: ArrayLike, R: ArrayLike) -> Floats:
    """How far the surface is pushed in at the distance ``r`` [m]; zero at and beyond the edge.

        delta(r) = delta - R + sqrt(R^2 - r^2),    0 <= r <= a

    At ``r = 0`` it is ``delta``.
    """
    R, delta = _sphere(R, delta)
    r = not_negative("distance from the centre", r, "m")
    sag = r**2 / (R + np.sqrt(np.maximum(R**2 - r**2, 0.0)))
    return np.where(r <= R, np.maximum(delta - sag, 0.0), 0.0)


def parabolic_radius(delta: ArrayLike, R: ArrayLike, kappa: ArrayLike = GEOMETRIC) -> Floats:
    """Contact radius of a paraboloid [m], eq. (32) with a factor.

        a = sqrt(kappa R delta)

    The paper has ``kappa = 2``, eq. (1) without the second-order term. It is the radius of the cut, not
    of the contact: on an elastic half space the surface sinks in around the patch and ``kappa = 1``
    ([Hertz1882]_); incompressible skin over a hard core bulges and comes near 2. At ``delta = 0.2 R`` eq.
    (32) exceeds eq. (1) by 11 % in the area and 5.4 % in the radius (the paper's footnote 4, "about 10
    %", is the area).
    """
    R, delta = positive("fingertip radius", R, "m"), not_negative("indentation", delta, "m")
    return np.sqrt(positive("radius factor kappa", kappa) * R * delta)


def _sphere(R: ArrayLike, delta: ArrayLike) -> tuple[Floats, Floats]:
    R, delta = positive("fingertip radius", R, "m"), not_negative("indentation", delta, "m")
    if np.any(delta > R):
        raise DomainError("the indentation is larger than the radius of the fingertip")
    return R, delta
