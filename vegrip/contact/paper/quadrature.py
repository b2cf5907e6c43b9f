"""Tables I and II a second time, from the integral (24) instead of the closed form (4).

The two share nothing but the profile of eq. (2), so ``vegrip paper`` prints them side by side.
"""

import math

from scipy.integrate import quad


def coefficient(k: float) -> float:
    """``C_k`` from equilibrium, eqs. (3), (24): ``1 / int_0^1 [1 - r^k]^(1/k) 2 r dr``, to about 1e-10.

    With ``r = 1 - s^2`` the steep edge of the profile at ``r = 1`` is smooth enough for adaptive quadrature.
    """
    if math.isinf(k):
        return 1.0

    def ring(s: float) -> float:
        r = 1 - s * s
        return float((1 - r**k) ** (1 / k) * 2 * r * 2 * s)

    share, _ = quad(ring, 0, 1, epsabs=1e-13, epsrel=1e-12, limit=400)
    return 1 / share
