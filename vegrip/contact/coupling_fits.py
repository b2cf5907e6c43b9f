"""The paper's fitted forms of the coupling: a power law for ``C_k - 1``, an exponential for the radius.

They are here to be compared with the paper; :mod:`vegrip.contact.coupling` needs no fit. The paper states
neither samples nor weights, which leaves the coefficients open by about 3 %; canonical here are ``k = 2,
2.1 .. 4`` and weights that undo the logarithm to first order.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from vegrip.contact.coupling import radius_ratio
from vegrip.contact.domain import positive, within
from vegrip.contact.pressure import coefficient, coefficient_excess
from vegrip.types import Floats

CANONICAL_K = np.linspace(2.0, 4.0, 21)

Weights = Literal["equal", "y", "y^2"]


@dataclass(frozen=True)
class PowerFit:
    """``C_k = 1 + A k^B``, eqs. (37), (38), and the exponent it gives, eq. (40)."""

    A: float
    B: float

    @property
    def alpha(self) -> float:
        """``A^(-1/B)``."""
        return float(self.A ** (-1 / self.B))

    @property
    def beta(self) -> float:
        """``1 / B``."""
        return 1 / self.B

    def coefficient(self, k: ArrayLike) -> Floats:
        """``C_k = 1 + A k^B``, eq. (38)."""
        return 1 + self.A * positive("pressure exponent k", k) ** self.B

    def exponent(self, h: ArrayLike, C0: float = 1.5) -> Floats:
        """``k = alpha (C_k0 / h - 1)^beta``, eq. (40); ``h < C_k0``. It misses ``k_0`` at ``h = 1``."""
        h = within("creep ratio h", h, 1e-3, C0 * (1 - 1e-4))
        return self.alpha * (C0 / h - 1) ** self.beta


@dataclass(frozen=True)
class RadiusFit:
    """``1 / sqrt(C_k) = D - A exp(-B k)``, eq. (59); the paper has ``D = 1``."""

    A: float
    B: float
    D: float = 1.0

    def inverse_root(self, k: ArrayLike) -> Floats:
        """``1 / sqrt(C_k)`` of the fit, eqs. (59), (64)."""
        return self.D - self.A * np.exp(-self.B * within("pressure exponent k", k, 2.0, 4.0))

    def radius_ratio(self, k: ArrayLike, k0: float = 2.0) -> Floats:
        """``a / a_0 = sqrt(C_k0)(1 - A exp(-B k))``, eqs. (26), (65), ``2 <= k <= 4``; 0.65 % high at 2."""
        return np.sqrt(coefficient(k0)) * self.inverse_root(k)


def fit_power(k: ArrayLike = CANONICAL_K) -> PowerFit:
    """Straight line through ``ln(C_k - 1)`` against ``ln k`` at the samples ``k``, eq. (37)."""
    k = positive("pressure exponent k", k)
    slope, intercept = np.polyfit(np.log(k), np.log(coefficient_excess(k)), 1)
    return PowerFit(float(np.exp(intercept)), float(slope))


def fit_radius(k: ArrayLike = CANONICAL_K, weights: Weights = "y^2") -> RadiusFit:
    """Weighted linear least squares of the logarithm, eqs. (59)-(64).

        y_i = 1 - 1/sqrt(C_ki),    ln y = X th,    X rows [1, -k_i],    th = [ln A, B]
        th = (X^T W X)^-1 X^T W ln y

    An error of ``ln y`` is an error of ``y`` divided by ``y``; ``W = diag(y^2)`` makes up for it to first
    order.
    """
    k = positive("pressure exponent k", k)
    y = 1 - 1 / np.sqrt(coefficient(k))
    w = {"equal": np.ones_like(y), "y": y, "y^2": y**2}[weights]
    X = np.column_stack([np.ones_like(k), -k])
    ln_A, B = np.linalg.solve(X.T @ (w[:, None] * X), X.T @ (w * np.log(y)))
    return RadiusFit(float(np.exp(ln_A)), float(B))


def fit_radius_directly(k: ArrayLike = CANONICAL_K, *, offset: bool = False) -> RadiusFit:
    """Nonlinear least squares of ``1 / sqrt(C_k)`` itself; ``offset`` frees the asymptote ``D`` too."""
    k = positive("pressure exponent k", k)
    start = fit_radius(k)
    wanted = radius_ratio(k, np.inf)  # 1 / sqrt(C_k), as C_inf = 1

    def error(p: Floats) -> Floats:
        asymptote = p[2] if offset else 1.0
        return np.asarray(asymptote - p[0] * np.exp(-p[1] * k) - wanted)

    first = [start.A, start.B, 1.0] if offset else [start.A, start.B]
    best = least_squares(error, first, xtol=1e-14, ftol=1e-14, gtol=1e-14).x
    return RadiusFit(*(float(p) for p in best))
