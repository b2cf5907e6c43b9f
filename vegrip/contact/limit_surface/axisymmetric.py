"""The limit surface of any axisymmetric pressure profile, by the same rings as the paper's."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from vegrip.contact.domain import not_negative
from vegrip.contact.limit_surface.reference import angle_to_distance, load_angle
from vegrip.contact.limit_surface.rings import integrate, point_of_rings
from vegrip.errors import DomainError
from vegrip.types import Floats


class AxisymmetricSurface:
    """Limit surface under a pressure profile p(r), r in [0, 1] the distance from the centre over the radius.

    The profile takes and gives arrays; pressures are >= 0 in any unit, their scale does not matter. Between
    the knots it is smooth: a measured profile, linear between radii, has its radii as knots.

    >>> hertz = AxisymmetricSurface(lambda r: np.sqrt(1 - r**2))
    >>> f, m = hertz.point(0.5)
    >>> print(f"{f:.6f} {m:.6f}")
    0.552233 0.455592

    Raises:
        DomainError: pressure negative somewhere or nowhere positive; knots that do not go from 0 to 1; a
            profile that is not smooth between the knots.

    """

    def __init__(self, profile: Callable[[Floats], Floats], knots: Sequence[float] = (0.0, 1.0)) -> None:
        if knots[0] != 0.0 or knots[-1] != 1.0 or any(low >= high for low, high in pairwise(knots)):
            raise DomainError(f"knots must grow from 0 at the centre to 1 at the edge, not {list(knots)}")
        if np.any(np.asarray(profile(np.linspace(0.0, 1.0, 65))) < 0.0):
            raise DomainError("a contact cannot pull: the pressure profile is negative somewhere")
        self._profile = profile
        self._knots = tuple(knots)
        parts = [integrate(self._per_radius, np.array(low), np.array(high)) for low, high in pairwise(knots)]
        self._force = float(sum(parts))
        if not 0.0 < self._force < np.inf:
            raise DomainError("the pressure profile carries no normal force")

    def point(self, d: ArrayLike) -> tuple[Floats, Floats]:
        """Point (f, m) for a COR at distance d [contact radii], normalised by mu N and mu N a."""
        d = not_negative("distance of the centre of rotation", d, "contact radii")
        return point_of_rings(lambda r: self._per_radius(r) / self._force, d, knots=self._knots)

    def support(self, d: ArrayLike) -> Floats:
        """Support function W(d) = d f + m of the slip about a COR at a finite distance d."""
        f, m = self.point(d)
        return np.asarray(np.asarray(d, dtype=np.float64) * f + m)

    def radius(self, psi: ArrayLike) -> Floats:
        """Distance from the origin to the surface along f = r cos(psi), m = r sin(psi)."""
        return np.hypot(*self.point(self.cor_distance(psi)))

    def cor_distance(self, psi: ArrayLike) -> Floats:
        """Distance of the COR [contact radii] when the load at the angle psi in [0, pi/2] starts to slip."""
        return angle_to_distance(self.point, load_angle(psi))

    def _per_radius(self, r: Floats) -> Floats:
        return np.asarray(self._profile(r) * r)
