"""The numbers behind the paper's tables and figures; eq. (4) inverted exactly, not by the paper's fit.

Tables I and II stand here a second time from the integral (24), which shares nothing with the closed form (4)
but the profile of eq. (2). The paper's fitted forms of the coupling, a power law for ``C_k - 1`` and an
exponential for the radius, are only compared with: it states neither samples nor weights, which leaves the
coefficients open by about 3 %; canonical here are ``k = 2, 2.1 .. 4`` and weights that undo the logarithm to
first order.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.optimize import least_squares

from vegrip.contact.coupling import exponent_after_creep, radius_ratio
from vegrip.contact.domain import positive, within
from vegrip.contact.limit_surface import reference
from vegrip.contact.pressure import coefficient, coefficient_excess
from vegrip.contact.prony import Creep, Relaxation
from vegrip.types import Floats

RELAXATION = Relaxation([0.3], [3.1])  # fig. 4: c_0 = 0.7, c_1 = 0.3, nu_1 = 3.1 1/s
CREEP = Creep([0.3], [3.1])  # eq. (41), figs. 7, 8, 10
K0 = 2.0  # the profile at the instant of loading

TABLE_1_K = (*range(1, 11), 50, math.inf)
TABLE_2_K = (2.0, 2.2, 2.4, 2.5, 2.6, 2.8, 3.0, 3.2, 3.4, 3.5, 3.6, 3.8, 4.0)

TIMES = (0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, math.inf)  # [s]
CURVE_TIMES = (0.0, 0.1, 0.2, 0.5, 1.0, math.inf)  # [s] few enough to distinguish the curves

LIMIT_SURFACE_K = (2, 3, 4)
DISTANCES = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)  # [contact radii] of the COR
FIG_10_TIMES = (0.0, 0.2, 1.0, math.inf)  # [s]
FIG_10_DISTANCES = (0.0, 0.25, 0.5, 1.0, 2.0)  # [contact radii]


def coefficient_by_quadrature(k: float) -> float:
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


Rows = list[list[float]]


def table_1(k: Sequence[float] = TABLE_1_K) -> dict[str, float]:
    """Table I: ``C_k`` for selected ``k``."""
    return {f"{x:g}": float(coefficient(x)) for x in k}


def table_2(k: Sequence[float] = TABLE_2_K) -> dict[str, list[float]]:
    """Table II: ``[C_k, a/a_0]`` for ``k`` between 2 and 4, eq. (25)."""
    return {f"{x:.1f}": [float(coefficient(x)), float(radius_ratio(x, K0))] for x in k}


def limit_surface(k: float, distances: Sequence[float] = DISTANCES) -> Rows:
    """Limit surface at constant area, eqs. (49), (50): rows ``[d/a, f/(mu N), m/(mu N a)]``."""
    return _rows(distances, *reference.point(k, distances))


def relaxation(times: Sequence[float] = TIMES) -> Rows:
    """Fig. 4 (a): rows ``[t, N/N_e]`` at constant displacement."""
    return _rows(times, RELAXATION(times))


def creep(times: Sequence[float] = TIMES) -> Rows:
    """Figs. 7 (b), 8: rows ``[t, h, a/a_0, C_k, k, p_max/p_0]`` at constant load, eqs. (34), (36), (23)."""
    h = CREEP(times)
    k = exponent_after_creep(h, K0).k
    C = coefficient(k)
    return _rows(times, h, np.sqrt(h), C, k, C / h)


def crept_surface(t: ArrayLike, distances: ArrayLike = FIG_10_DISTANCES) -> tuple[float, Floats, Floats]:
    """Fig. 10, eqs. (51), (52): ``k``, ``f/(mu N)``, ``m/(mu N a_0)`` at the time ``t`` [s] under load."""
    h = CREEP(t)
    k = float(exponent_after_creep(h, K0).k)
    f, m = reference.point(k, distances)
    return k, f, m * np.sqrt(h)  # a/a_0: the moment is normalised by the radius at t = 0


def numbers() -> dict[str, object]:
    """All of it in the shape of ``vegrip paper --json``."""
    radius, power = fit_radius(), fit_power()
    return {
        "table1": table_1(),
        "table2": table_2(),
        "limit_surface": {str(k): limit_surface(k) for k in LIMIT_SURFACE_K},
        "fig4": relaxation(),
        "fig8": creep(),
        "fig10": [[t, k, _rows(f, m)] for t in FIG_10_TIMES for k, f, m in [crept_surface(t)]],
        "coupling_fit": {"A": radius.A, "B": radius.B},
        "log_fit": {"A": power.A, "B": power.B},
    }


def _rows(*columns: ArrayLike) -> Rows:
    return [[float(x) for x in row] for row in zip(*map(np.atleast_1d, columns), strict=True)]
