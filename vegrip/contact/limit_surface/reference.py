"""The limit surface of the paper's pressure, by adaptive quadrature: slow, exact, the judge of the fast path.

With lengths in contact radii and the ring means s of :mod:`~vegrip.contact.limit_surface.rings`, the surface
integrals (57), (58) of [TiezziKao2007]_ become one integral each over r in [0, 1]:

    f(d) = |f_t|/(mu N)   = int w_k(r)   s(d/r) dr        w_k(r) = 2 C_k (1 - r^k)^(1/k) r
    m(d) = |m_n|/(mu N a) = int w_k(r) r s(r/d) dr

d in [0, inf] is the distance of the centre of rotation (COR) from the contact centre, in contact radii: d = 0
is pure torsion, d = inf pure force. k in [1, inf]; k = inf is uniform pressure. Assumes Coulomb friction, the
same mu everywhere and in every direction, and a contact area that slips as a rigid body.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import tanhsinh
from scipy.special import gammaln

from vegrip.contact.limit_surface.rings import ring_mean
from vegrip.errors import DomainError

TOLERANCE = 1e-11
"""What the quadrature converges to, per panel; the points are good to 1e-10."""

Array = NDArray[np.float64]
_LARGE = 1e300  # stands for k = inf: inf * log(1) would be nan
_THIN = 1e-13  # a thinner panel has no room for distinct nodes, and weighs nothing


def point(k: ArrayLike, d: ArrayLike) -> tuple[Array, Array]:
    """Point (f, m) of the limit surface for a COR at distance d [contact radii] and pressure exponent k.

    k and d broadcast. Raises DomainError for k < 1 or d < 0, and when the quadrature does not reach
    `TOLERANCE`.
    """
    k, d = checked_exponent(k), _checked_distance(d)
    return _integral(_force, k, d), _integral(_torque, k, d)


def support(k: ArrayLike, d: ArrayLike) -> Array:
    """Support function W(d) = d f + m: friction power/(mu N a omega) of the slip about a COR at distance d.

    It is the dissipation potential: f = dW/dd, and no load on the surface does more power in this slip.
    """
    f, m = point(k, d)
    return np.asarray(np.asarray(d, dtype=float) * f + m)


def torsion_limit(k: ArrayLike) -> Array:
    """Greatest pure torque |m_n|/(mu N a), (2 C_k/k) B(3/k, 1 + 1/k), for k in [1, inf].

    Written with x = 1/k as (2/3) Gamma(1 + 3x)^2 / (Gamma(1 + 2x) Gamma(1 + 4x)): nothing special at k = inf.
    """
    x = 1.0 / checked_exponent(k)
    return np.asarray(
        2.0 / 3.0 * np.exp(2.0 * gammaln(1.0 + 3.0 * x) - gammaln(1.0 + 2.0 * x) - gammaln(1.0 + 4.0 * x))
    )


def checked_exponent(k: ArrayLike) -> Array:
    """Return k as an array, or raise DomainError unless every k is in [1, inf]."""
    k = np.asarray(k, dtype=float)
    if not np.all(k >= 1.0):
        raise DomainError(f"the pressure exponent must be in [1, inf], not {np.min(k)}")
    return k


def _checked_distance(d: ArrayLike) -> Array:
    d = np.asarray(d, dtype=float)
    if not np.all(d >= 0.0):
        raise DomainError(f"the distance of the centre of rotation must be in [0, inf], not {np.min(d)}")
    return d


def _integral(integrand: Callable[[Array, Array, Array], Array], k: Array, d: Array) -> Array:
    """Integrate over the rings, split at r = d where the ring means have an infinite slope."""
    k, d = np.broadcast_arrays(np.minimum(k, _LARGE), d)
    split = np.where(d < 1.0 - _THIN, d, 1.0)
    panels = [
        tanhsinh(integrand, lower, upper, args=(k, d), atol=TOLERANCE, rtol=TOLERANCE)
        for lower, upper in ((np.zeros_like(split), split), (split, np.ones_like(split)))
    ]
    if not all(np.all(panel.success) for panel in panels):
        worst = max(float(np.max(panel.error)) for panel in panels)
        raise DomainError(f"the limit-surface quadrature stopped at an error of {worst:.1e}")
    return np.asarray(panels[0].integral + panels[1].integral)


def _force(r: Array, k: Array, d: Array) -> Array:
    return _weight(r, k) * ring_mean(_ratio(d, r))


def _torque(r: Array, k: Array, d: Array) -> Array:
    return _weight(r, k) * r * ring_mean(_ratio(r, d))


def _weight(r: Array, k: Array) -> Array:
    """Share w_k(r) of the normal force per unit of radius; C_k is (4)."""
    x = 1.0 / k
    coefficient = np.exp(gammaln(1.0 + 3.0 * x) - gammaln(1.0 + x) - gammaln(1.0 + 2.0 * x))
    with np.errstate(divide="ignore"):  # log(0) at the centre is meant
        fall = -np.expm1(k * np.log(r))  # 1 - r^k without cancellation near the edge
    return np.asarray(2.0 * coefficient * fall**x * r)


def _ratio(over: Array, under: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(under > 0.0, over / under, np.inf)
