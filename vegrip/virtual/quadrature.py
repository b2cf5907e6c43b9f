"""Two quadrature rules on the unit interval, the only integrals the simulated contact rests on."""

from functools import cache

import numpy as np

from vegrip.types import Floats


@cache
def gauss_legendre(points: int) -> tuple[Floats, Floats]:
    """Return nodes and weights on 0..1, exact for polynomials of degree ``2 points - 1``."""
    x, w = np.polynomial.legendre.leggauss(points)
    return (x + 1.0) / 2.0, w / 2.0


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
