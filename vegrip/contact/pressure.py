"""Pressure over a circular patch: the family of profiles with exponent k, its coefficient, its limits.

Symbols: ``N`` [N] normal force, ``a`` [m] radius of the patch, ``r`` [m] distance from its centre, ``k`` [-]
exponent of the profile (1 cone-like, 2 Hertz, infinity uniform), ``C_k`` [-] its coefficient.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaln

from vegrip.contact.domain import not_negative, positive
from vegrip.contact.prony import Relaxation
from vegrip.types import Floats


def coefficient(k: ArrayLike) -> Floats:
    """Peak over mean pressure, eq. (4).

        C_k = (3/2) k Gamma(3/k) / (Gamma(1/k) Gamma(2/k))
            = Gamma(1 + 3/k) / (Gamma(1 + 1/k) Gamma(1 + 2/k))

    The second form is the one computed: its gammas stay near 1 however large ``k`` is. ``k = inf`` gives 1.
    """
    return 1.0 + coefficient_excess(k)


def coefficient_excess(k: ArrayLike) -> Floats:
    """``C_k - 1``, without the cancellation that would spoil its logarithm at large ``k``."""
    u = 1 / positive("pressure exponent k", k)
    return np.expm1(gammaln(1 + 3 * u) - gammaln(1 + u) - gammaln(1 + 2 * u))


def profile(r_hat: ArrayLike, k: ArrayLike) -> Floats:
    """Pressure over peak pressure, ``[1 - r_hat^k]^(1/k)``, at ``r_hat = r / a``; zero outside the patch."""
    r_hat = not_negative("distance from the centre", r_hat)
    k = positive("pressure exponent k", k)
    inside = np.minimum(r_hat, 1.0)
    return np.where(r_hat <= 1, (1 - inside**k) ** (1 / k), 0.0)


def pressure(r: ArrayLike, N: ArrayLike, a: ArrayLike, k: ArrayLike) -> Floats:
    """Contact pressure [Pa], eq. (2); with ``N(t)`` eqs. (9) and (21), with ``a(t)``, ``k(t)`` eq. (22).

        p(r) = C_k N / (pi a^2) [1 - (r/a)^k]^(1/k)

    Its integral over the patch is ``N``, eqs. (3) and (24), whatever ``a`` and ``k`` are.
    """
    r_hat = np.asarray(r, dtype=np.float64) / positive("contact radius", a, "m")
    return peak_pressure(N, a, k) * profile(r_hat, k)


def peak_pressure(N: ArrayLike, a: ArrayLike, k: ArrayLike) -> Floats:
    """Pressure at the centre [Pa], eq. (23): ``C_k N / (pi a^2)``."""
    return coefficient(k) * mean_pressure(N, a)


def mean_pressure(N: ArrayLike, a: ArrayLike) -> Floats:
    """Normal force over area of the patch [Pa]."""
    return not_negative("normal force", N, "N") / (np.pi * positive("contact radius", a, "m") ** 2)


def pressure_after_step(
    r: ArrayLike, t: ArrayLike, N_e: ArrayLike, a: ArrayLike, k: ArrayLike, g: Relaxation
) -> Floats:
    """Pressure [Pa] at ``t`` [s] after a step of displacement whose elastic force is ``N_e`` [N], eq. (17).

    The elastic pressure times the reduced relaxation function: patch and profile stay, the force fades.
    """
    return pressure(r, N_e, a, k) * g(t)


def matthews_pressure(r: ArrayLike, N: ArrayLike, a: ArrayLike, n: ArrayLike) -> Floats:
    """Pressure [Pa] under a sphere on a material that hardens with exponent ``n >= 1`` [Matthews1980]_.

        p(r) = p_mean (2n + 1)/(2n) [1 - (r/a)^2]^(1/(2n))

    Footnote 2 of the paper. ``n = 1`` is Hertz, ``n -> infinity`` is uniform; the integral is ``N`` for
    all ``n``.
    """
    q = 1 / (2 * positive("hardening exponent n", n))
    r_hat = not_negative("distance from the centre", r, "m") / positive("contact radius", a, "m")
    inside = np.minimum(r_hat, 1.0)
    return np.where(r_hat <= 1, mean_pressure(N, a) * (1 + q) * (1 - inside**2) ** q, 0.0)


def torsion_limit(k: ArrayLike) -> Floats:
    """Largest torque without slip over ``mu N a``, for a patch that only twists: eq. (58) at ``d = 0``.

        m_max / (mu N a) = (2 C_k / k) Beta(3/k, 1 + 1/k)
                         = (2/3) Gamma(1 + 3/k)^2 / (Gamma(1 + 2/k) Gamma(1 + 4/k))

    The closed form is not in the paper. 1/2 for ``k = 1``, ``3 pi / 16`` for Hertz, 2/3 for uniform pressure.
    """
    u = 1 / positive("pressure exponent k", k)
    return (2 / 3) * np.exp(2 * gammaln(1 + 3 * u) - gammaln(1 + 2 * u) - gammaln(1 + 4 * u))
