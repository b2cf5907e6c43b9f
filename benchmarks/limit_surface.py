"""Queries to the limit surface, against scipy's ``dblquad`` and against a search for the centre of rotation.

Both rivals get the tolerance that our own error calls for, and the search the ring integrals in closed form.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import dblquad, quad
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from benchmarks._timing import compared
from vegrip.contact.limit_surface import fast, reference

K = 2.5  # pressure exponent
D = 0.6  # distance of the centre of rotation in contact radii

Timed = dict[str, float]


def run() -> dict[str, Timed]:
    """Compare the point of a slip centre with a double integral, the gauge of a load with a search."""
    f, m = (float(part) for part in reference.point(K, D))
    assert np.allclose(fast.point(K, D), (f, m), atol=1e-3)
    assert np.allclose(area_point(D), (f, m), atol=1e-3)
    assert math.isclose(search_gauge(f, m), 1.0, rel_tol=1e-4)
    assert math.isclose(fast.gauge(K, f, m), 1.0, rel_tol=1e-4)
    return {
        "limit_surface_vs_dblquad": compared(lambda: fast.point(K, D), lambda: area_point(D)),
        "limit_surface_vs_cor_search": compared(lambda: fast.gauge(K, f, m), lambda: search_gauge(f, m)),
    }


def area_point(d: float) -> tuple[float, float]:
    """Equations (49) and (50) as they stand: two double integrals over the contact, to 1e-3."""
    scale = float(math.gamma(1 + 3 / K) / (math.gamma(1 + 1 / K) * math.gamma(1 + 2 / K))) / math.pi

    def integral(direction: Callable[[float, float], float]) -> float:
        def integrand(r: float, theta: float) -> float:
            rho = math.sqrt(r * r + d * d - 2 * r * d * math.cos(theta))
            return direction(r, theta) / rho * (1 - r**K) ** (1 / K) * r if rho > 0 else 0.0

        return float(2 * scale * dblquad(integrand, 0, math.pi, 0, 1, epsabs=1e-3, epsrel=1e-3)[0])

    force = integral(lambda r, theta: d - r * math.cos(theta))
    torque = integral(lambda r, theta: r * r - r * d * math.cos(theta))
    return force, torque


def search_gauge(f: float, m: float) -> float:
    """Find the centre of rotation whose load is along (f, m); the gauge is load over that load."""

    def across(d: float) -> float:
        limit_f, limit_m = ring_point(d)
        return limit_m * f - limit_f * m

    d = float(brentq(across, 1e-9, 1e3, rtol=1e-6))
    return math.hypot(f, m) / math.hypot(*ring_point(d))


def ring_point(d: float) -> tuple[float, float]:
    """One integral over rings each for force and torque, to 1e-5."""
    scale = 2 * math.gamma(1 + 3 / K) / (math.gamma(1 + 1 / K) * math.gamma(1 + 2 / K)) / math.pi

    def ring(r: float, sign: int) -> float:
        modulus = 1 - ((r - d) / (r + d)) ** 2
        along = (r - d) * ellipk(modulus) if modulus < 1 else 0.0
        return float(scale * (1 - r**K) ** (1 / K) * r * ((r + d) * ellipe(modulus) + sign * along))

    split = [d] if d < 1 else None
    f = quad(ring, 0, 1, args=(-1,), points=split, epsabs=1e-5, epsrel=1e-5)[0] / d
    m = quad(ring, 0, 1, args=(1,), points=split, epsabs=1e-5, epsrel=1e-5)[0]
    return float(f), float(m)
