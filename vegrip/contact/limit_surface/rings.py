"""Friction of one ring of the contact: the angle integrals of (57), (58) in closed form.

A ring of radius r slips about a centre of rotation (COR) at distance d from its own centre. Averaged over the
ring, with rho the distance from the COR and e the unit vector of the slip speed,

    <force along the slip of the centre>  = mean of (d - r cos th)/rho   = s(d/r)
    <torque about the ring's centre> / r  = mean of (r - d cos th)/rho   = s(r/d)

with one function s, because both are derivatives of the same mean distance <rho>, symmetric in r and d:

    s(q) = (2/pi) q (1-q^2) R_D(0, 1, 1-q^2) / 3       q < 1
    s(q) = (2/pi) E(1/q^2)                             q > 1

R_D is Carlson's symmetric integral, free of the cancellation that E - (1-m)K suffers at small q. s is
continuous with s(1) = 2/pi and infinite slope there: quadratures over rings split at r = d.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ellipe, elliprd


def ring_mean(q: ArrayLike) -> NDArray[np.float64]:
    """Mean friction s(q) of a ring, q >= 0 (any shape); s(0) = 0, s(inf) = 1."""
    q = np.asarray(q, dtype=float)
    inside = np.minimum(q, 1.0)
    gap = np.where(q < 1.0, (1.0 - inside) * (1.0 + inside), 1.0)
    near = np.where(q < 1.0, inside * gap * elliprd(0.0, 1.0, gap) / 3.0, 1.0)
    far = ellipe(1.0 / np.maximum(q, 1.0) ** 2)
    return np.asarray(2.0 / np.pi * np.where(q < 1.0, near, far))
