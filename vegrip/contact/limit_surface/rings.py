"""Friction of a contact made of concentric rings: the angle integrals of (57), (58) in closed form.

A ring of radius r slips about a centre of rotation (COR) at distance d from its own centre. Averaged over the
ring, with rho the distance from the COR,

    force across the line to the COR       mean of (d - r cos th)/rho     = s(d/r)
    torque about the ring's centre, over r mean of (r - d cos th)/rho     = s(r/d)

with one function s, because both are derivatives of the same mean distance <rho>, symmetric in r and d:

    s(q) = (2/pi) q (1-q^2) R_D(0, 1, 1-q^2) / 3       q < 1
    s(q) = (2/pi) E(1/q^2)                             q > 1

R_D is Carlson's symmetric integral, free of the cancellation that E - (1-m)K suffers at small q. s is
continuous with s(1) = 2/pi and infinite slope there, so integrals over rings are split at r = d.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import tanhsinh
from scipy.special import ellipe, elliprd

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
