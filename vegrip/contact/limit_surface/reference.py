"""The limit surface of the paper's pressure, by adaptive quadrature: slow, exact, the judge of the fast path.

With lengths in contact radii and the ring means s of :mod:`~vegrip.contact.limit_surface.rings`, the surface
integrals (53)-(58) of [TiezziKao2007]_, normalised as in (49), (50), become one integral each over r:

    f(d) = |f_t|/(mu N)   = int w_k(r)   s(d/r) dr        w_k(r) = 2 C_k (1 - r^k)^(1/k) r
    m(d) = |m_n|/(mu N a) = int w_k(r) r s(r/d) dr

d in [0, inf] is the distance of the centre of rotation (COR) from the contact centre, in contact radii: d = 0
is pure torsion, d = inf pure force. k in [1, inf]; k = inf is uniform pressure. Assumes Coulomb friction, the
same mu everywhere and in every direction, and a contact area that slips as a rigid body.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize.elementwise import find_root
from scipy.special import gammaln

from vegrip.contact.domain import not_negative, within
from vegrip.contact.limit_surface.rings import point_of_rings
from vegrip.contact.pressure import coefficient
from vegrip.types import Floats

_LARGE = 1e300  # stands for k = inf: inf * log(1) would be nan
_FORCE = 1e-15  # [rad] below it tan of the solved angle is beyond what a double tells from pi/2


def point(k: ArrayLike, d: ArrayLike) -> tuple[Floats, Floats]:
    """Point (f, m) of the limit surface, good to 1e-12, for a COR at distance d [contact radii].

    k and d broadcast. Raises DomainError for k < 1 or d < 0.
    """
    k, d = exponent(k), not_negative("distance of the centre of rotation", d, "contact radii")
    return point_of_rings(_share, d, np.minimum(k, _LARGE))


def support(k: ArrayLike, d: ArrayLike) -> Floats:
    """Support function W(d) = d f + m: friction power/(mu N a omega) of the slip about a COR at distance d.

    It is the dissipation potential: f = dW/dd, and no load on the surface does more power in this slip.
    d must be finite.
    """
    f, m = point(k, d)
    return np.asarray(np.asarray(d, dtype=np.float64) * f + m)


def torsion_limit(k: ArrayLike) -> Floats:
    """Greatest pure torque |m_n|/(mu N a), (2 C_k/k) B(3/k, 1 + 1/k), for k in [1, inf].

    Written with x = 1/k as (2/3) Gamma(1 + 3x)^2 / (Gamma(1 + 2x) Gamma(1 + 4x)): nothing special at k = inf.
    """
    x = 1.0 / exponent(k)
    gammas = 2.0 * gammaln(1.0 + 3.0 * x) - gammaln(1.0 + 2.0 * x) - gammaln(1.0 + 4.0 * x)
    return np.asarray(2.0 / 3.0 * np.exp(gammas))


def cor_distance(k: ArrayLike, psi: ArrayLike) -> Floats:
    """Distance d [contact radii] of the COR when the load f = r cos(psi), m = r sin(psi) starts to slip.

    psi in [0, pi/2]; pi/2 (torsion) gives 0 and 0 (force) gives inf.
    """
    return angle_to_distance(point, *np.broadcast_arrays(load_angle(psi), exponent(k)))


def radius(k: ArrayLike, psi: ArrayLike) -> Floats:
    """Distance from the origin to the limit surface along the load f = r cos(psi), m = r sin(psi)."""
    return np.hypot(*point(k, cor_distance(k, psi)))


def angle_to_distance(
    point: Callable[..., tuple[Floats, Floats]], psi: Floats, *parameters: Floats
) -> Floats:
    """Solve for the COR distance d whose point(..., d) lies along psi; one shape for all arrays.

    The angle of the point falls from pi/2 to 0 as d grows, so that arctan(d) is bracketed by [0, pi/2].
    """

    def across(arctan_d: Floats, psi: Floats, *parameters: Floats) -> Floats:
        f, m = point(*parameters, np.tan(arctan_d))
        return m * np.cos(psi) - f * np.sin(psi)

    force = psi < _FORCE
    ends = np.zeros(psi.shape), np.full(psi.shape, np.pi / 2.0)
    root = find_root(across, ends, args=(np.where(force, np.pi / 4.0, psi), *parameters))
    return np.where(force, np.inf, np.tan(root.x))


def exponent(k: ArrayLike) -> Floats:
    """Return k as doubles, or raise DomainError unless every k is in [1, inf]."""
    return within("pressure exponent k", k, 1.0, np.inf)


def load_angle(psi: ArrayLike) -> Floats:
    """Return psi as doubles, or raise DomainError unless every psi is in [0, pi/2]."""
    return within("load angle", psi, 0.0, np.pi / 2.0, "rad")


def _share(r: Floats, k: Floats) -> Floats:
    """Share w_k(r) of the normal force per unit of radius."""
    with np.errstate(divide="ignore"):  # log(0) at the centre is meant
        fall = -np.expm1(k * np.log(r))  # 1 - r^k without cancellation near the edge
    return np.asarray(2.0 * coefficient(k) * fall ** (1.0 / k) * r)
