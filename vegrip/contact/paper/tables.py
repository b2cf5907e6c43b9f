"""The numbers behind the paper's tables and figures; eq. (4) inverted exactly, not by the paper's fit."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from vegrip.contact.coupling import exponent_after_creep, radius_ratio
from vegrip.contact.coupling_fits import fit_power, fit_radius
from vegrip.contact.domain import Floats
from vegrip.contact.limit_surface import reference
from vegrip.contact.paper import setting
from vegrip.contact.pressure import coefficient

Rows = list[list[float]]


def table_1(k: Sequence[float] = setting.TABLE_1_K) -> dict[str, float]:
    """Table I: ``C_k`` for selected ``k``."""
    return {f"{x:g}": float(coefficient(x)) for x in k}


def table_2(k: Sequence[float] = setting.TABLE_2_K) -> dict[str, list[float]]:
    """Table II: ``[C_k, a/a_0]`` for ``k`` between 2 and 4, eq. (25)."""
    return {f"{x:.1f}": [float(coefficient(x)), float(radius_ratio(x, setting.K0))] for x in k}


def limit_surface(k: float, distances: Sequence[float] = setting.DISTANCES) -> Rows:
    """Limit surface at constant area, eqs. (49), (50): rows ``[d/a, f/(mu N), m/(mu N a)]``."""
    return _rows(distances, *reference.point(k, distances))


def relaxation(times: Sequence[float] = setting.TIMES) -> Rows:
    """Fig. 4 (a): rows ``[t, N/N_e]`` at constant displacement."""
    return _rows(times, setting.RELAXATION(times))


def creep(times: Sequence[float] = setting.TIMES) -> Rows:
    """Figs. 7 (b), 8: rows ``[t, h, a/a_0, C_k, k, p_max/p_0]`` at constant load, eqs. (34), (36), (23)."""
    h = setting.CREEP(times)
    k = exponent_after_creep(h, setting.K0).k
    C = coefficient(k)
    return _rows(times, h, np.sqrt(h), C, k, C / h)


def crept_surface(
    t: ArrayLike, distances: ArrayLike = setting.FIG_10_DISTANCES
) -> tuple[float, Floats, Floats]:
    """Fig. 10, eqs. (51), (52): ``k``, ``f/(mu N)``, ``m/(mu N a_0)`` at the time ``t`` [s] under load."""
    h = setting.CREEP(t)
    k = float(exponent_after_creep(h, setting.K0).k)
    f, m = reference.point(k, distances)
    return k, f, m * np.sqrt(h)  # a/a_0: the moment is normalised by the radius at t = 0


def numbers() -> dict[str, object]:
    """All of it in the shape of ``vegrip paper --json``."""
    radius, power = fit_radius(), fit_power()
    return {
        "table1": table_1(),
        "table2": table_2(),
        "limit_surface": {str(k): limit_surface(k) for k in setting.LIMIT_SURFACE_K},
        "fig4": relaxation(),
        "fig8": creep(),
        "fig10": [[t, k, _rows(f, m)] for t in setting.FIG_10_TIMES for k, f, m in [crept_surface(t)]],
        "coupling_fit": {"A": radius.A, "B": radius.B},
        "log_fit": {"A": power.A, "B": power.B},
    }


def _rows(*columns: ArrayLike) -> Rows:
    return [[float(x) for x in row] for row in zip(*map(np.atleast_1d, columns), strict=True)]
