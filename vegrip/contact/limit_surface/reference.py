"""The limit surface of the paper's pressure and of any round profile, by quadrature over rings.

Slow and exact: the judge of the fast path. A ring of radius r slips about a centre of rotation (COR) at
distance d from its own centre. Averaged over the ring, with rho the distance from the COR,

    force across the line to the COR       mean of (d - r cos th)/rho     = s(d/r)
    torque about the ring's centre, over r mean of (r - d cos th)/rho     = s(r/d)

with one function s, because both are derivatives of the same mean distance <rho>, symmetric in r and d; they
are the angle integrals of (57), (58) in closed form:

    s(q) = (2/pi) q (1-q^2) R_D(0, 1, 1-q^2) / 3       q < 1
    s(q) = (2/pi) E(1/q^2)                             q > 1

R_D is Carlson's symmetric integral, free of the cancellation that E - (1-m)K suffers at small q. s is
continuous with s(1) = 2/pi and infinite slope there, so integrals over rings are split at r = d.

With lengths in contact radii the surface integrals (53)-(58) of [TiezziKao2007]_, normalised as in (49),
(50), become one integral each over r:

    f(d) = |f_t|/(mu N)   = int w_k(r)   s(d/r) dr        w_k(r) = 2 C_k (1 - r^k)^(1/k) r
    m(d) = |m_n|/(mu N a) = int w_k(r) r s(r/d) dr

d in [0, inf] is the distance of the COR from the contact centre, in contact radii: d = 0 is pure torsion,
d = inf pure force. k in [1, inf]; k = inf is uniform pressure. Assumes Coulomb friction, the same mu
everywhere and in every direction, and a contact area that slips as a rigid body.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import tanhsinh
from scipy.optimize.elementwise import find_root
from scipy.special import ellipe, elliprd

from vegrip.contact.domain import not_negative, within
from vegrip.contact.pressure import coefficient
from vegrip.contact.pressure import torsion_limit as torsion_limit  # noqa: PLC0414 (reads as one surface)
from vegrip.errors import DomainError
from vegrip.types import Floats

TOLERANCE = 1e-12
"""What the quadrature converges to, absolute and relative."""

_LEAST_LEVEL = (
    4  # at levels 2 and 3 two estimates may agree by chance: 4e-9 of the force at d = 1e-3 was lost
)
_THIN = 1e-13  # a thinner panel has no room for distinct nodes, and weighs nothing


def ring_mean(q: ArrayLike) -> Floats:
    """Mean friction s(q) of a ring, q >= 0 (any shape); s(0) = 0, s(inf) = 1."""
    q = np.asarray(q, dtype=np.float64)
    inside = np.minimum(q, 1.0)
    gap = np.where(q < 1.0, (1.0 - inside) * (1.0 + inside), 1.0)
    near = np.where(q < 1.0, inside * gap * elliprd(0.0, 1.0, gap) / 3.0, 1.0)
    far = ellipe(1.0 / np.maximum(q, 1.0) ** 2)
    return np.asarray(2.0 / np.pi * np.where(q < 1.0, near, far))


def point_of_rings(
    share: Callable[..., Floats], d: Floats, *parameters: Floats, knots: Sequence[float] = (0.0, 1.0)
) -> tuple[Floats, Floats]:
    """Limit-surface point (f, m) for a COR at distance d [contact radii].

    share(r, ...) is the part of the normal force per unit of radius r in [0, 1], smooth between knots; at the
    knots themselves it may have any behaviour that can be integrated. d and the parameters broadcast.
    """

    def force(r: Floats, d: Floats, *parameters: Floats) -> Floats:
        return share(r, *parameters) * ring_mean(_ratio(d, r))

    def torque(r: Floats, d: Floats, *parameters: Floats) -> Floats:
        return share(r, *parameters) * r * ring_mean(_ratio(r, d))

    f, m = np.zeros(()), np.zeros(())
    for lower, upper in pairwise(knots):
        split = np.where(d - lower < _THIN, lower, np.where(upper - d < _THIN, upper, d))
        for panel in ((np.full_like(split, lower), split), (split, np.full_like(split, upper))):
            f = f + integrate(force, *panel, d, *parameters)
            m = m + integrate(torque, *panel, d, *parameters)
    return f, m


def integrate(term: Callable[..., Floats], lower: Floats, upper: Floats, *parameters: Floats) -> Floats:
    """Integrate term(r, ...) by adaptive tanh-sinh quadrature; DomainError if it misses `TOLERANCE`."""
    result = tanhsinh(
        term, lower, upper, args=parameters, minlevel=_LEAST_LEVEL, atol=TOLERANCE, rtol=TOLERANCE
    )
    if not np.all(result.success):
        raise DomainError(
            f"the quadrature over the contact stopped at an error of {np.max(result.error):.1e}; "
            "give the radii at which the pressure profile has a kink or a jump as knots"
        )
    return np.asarray(result.integral)


def _ratio(over: Floats, under: Floats) -> Floats:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(under > 0.0, over / under, np.inf)


_LARGE = 1e300  # stands for k = inf: inf * log(1) would be nan
_FORCE = 1e-15  # [rad] below it tan of the solved angle is beyond what a double distinguishes from pi/2


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
    with np.errstate(divide="ignore"):  # log(0) at the centre is meant
        fall = -np.expm1(k * np.log(r))  # 1 - r^k without cancellation near the edge
    return np.asarray(2.0 * coefficient(k) * fall ** (1.0 / k) * r)


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
        if not self._force > 0.0:
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
