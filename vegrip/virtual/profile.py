"""The pressure over the simulated contact: by quadrature and table look-up, without any closed form.

The pressure has the shape ``[1 - (r/a)^k]^(1/k)`` ([TiezziKao2007]_, eq. (2)). Everything else about it is
integrated here: the constant that makes it carry the normal force, the share of the force inside a radius,
and, by inverting a table, the exponent that belongs to a constant.
"""

from functools import cache

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels

EXPONENTS = np.geomspace(kernels.LOWEST_EXPONENT, kernels.HIGHEST_EXPONENT, kernels.EXPONENTS)
"""Pressure exponents k of the tables [-]: from sharper than Hertz to nearly uniform."""

HERTZ = 2.0
"""Exponent of a contact that has just been made [-]."""


def share_within(k: Floats, r: Floats) -> Floats:
    """Return ``2 int_0^r s [1 - s^k]^(1/k) ds`` for radii 0 < r <= 1; shape of k plus shape of r.

    Substituted ``s = r x`` and integrated by the double-exponential rule.
    """
    x, log_x, weights = tanh_sinh()
    k = np.asarray(k, float)[..., None, None]
    r = np.asarray(r, float)[:, None]
    height = (-np.expm1(k * (np.log(r) + log_x))) ** (1.0 / k)  # 1 - s^k without cancellation at the rim
    share: Floats = 2.0 * r[:, 0] ** 2 * ((height * x) @ weights)
    return share


@cache
def normalisation() -> Floats:
    """Return C_k at :data:`EXPONENTS`: what makes the pressure integrate to the normal force."""
    total = share_within(EXPONENTS, np.ones(1))[:, 0]
    coefficients: Floats = 1.0 / total
    return coefficients


@cache
def coefficient_logarithms() -> Floats:
    """Return ``-ln (C_k - 1)`` at :data:`EXPONENTS`: it grows, and is nearly straight in ``ln k``."""
    return -np.log(normalisation() - 1.0)


def coefficient(k: Floats) -> Floats:
    """Return C_k [-] of the exponents k [-], interpolated in the logarithms."""
    return 1.0 + np.exp(-np.interp(np.log(k), np.log(EXPONENTS), coefficient_logarithms()))


def exponent(C: float) -> float:
    """Return the k [-] whose coefficient C > 1 [-] is given; beyond the table its first or last k."""
    return float(kernels.pressure_exponent(C, coefficient_logarithms()))


@cache
def ring_shares(edges: tuple[float, ...]) -> Floats:
    """Return the share of the normal force on each ring at each of :data:`EXPONENTS`; (400, rings)."""
    shares = np.diff(share_within(EXPONENTS, np.array(edges[1:])), axis=1, prepend=0.0)
    carried: Floats = shares / shares.sum(axis=1, keepdims=True)
    return carried


def shares_on_rings(k: Floats, edges: tuple[float, ...]) -> Floats:
    """Return the share of the normal force on each ring for exponents k; (n, rings), rows sum to one."""
    shares = np.empty((len(k), len(edges) - 1))
    for one, row in zip(k.tolist(), shares, strict=True):
        kernels.share_out(one, ring_shares(edges), 1, row)
    return shares


@cache
def tanh_sinh(points: int = 81, reach: float = 3.2) -> tuple[Floats, Floats, Floats]:
    """Return nodes x, their logarithms, and weights on 0..1.

    The double-exponential rule [TakahasiMori1974]_ does not mind the vertical tangent that the pressure has
    at the rim; ``log x`` is returned apart because x has no digits left there.
    """
    t, step = np.linspace(-reach, reach, points, retstep=True)
    s = np.pi / 2 * np.sinh(t)
    x, rest = 1.0 / (1.0 + np.exp(-2.0 * s)), 1.0 / (1.0 + np.exp(2.0 * s))
    weights = step * np.pi * np.cosh(t) * x * rest
    return x, -np.log1p(np.exp(-2.0 * s)), weights
