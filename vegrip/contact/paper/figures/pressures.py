"""Figs. 2, 4, 5, 8: the pressure over the patch, and how it changes while load or displacement is held."""

import math
from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vegrip.contact.coupling import exponent_after_creep, radius_ratio
from vegrip.contact.domain import Floats
from vegrip.contact.paper import setting
from vegrip.contact.paper.figures.style import letter, panels, seconds, shades
from vegrip.contact.pressure import pressure, pressure_after_step

UNIT = np.pi  # N = pi and a_0 = 1 make the mean pressure at the start 1
TIME = np.linspace(0, 2, 401)  # [s]


def profiles() -> Figure:
    """Fig. 2: the family of profiles of eq. (2); all carry the same force."""
    figure, (ax,) = panels()
    exponents = (1, 1.5, 2, 3, 4, 6, 10, math.inf)
    r = np.linspace(-1, 1, 1001)
    for k, colour in zip(exponents, shades(len(exponents)), strict=True):
        label = r"$k \to \infty$" if math.isinf(k) else f"$k = {k:g}$"
        p = pressure(np.abs(r), UNIT, 1.0, k)
        ax.plot([-1, *r, 1], [0, *p, 0], color=colour, label=label)
    _label(ax, "$r / a$", r"$p\,/\,(N / \pi a^2)$")
    return figure


def relaxation() -> Figure:
    """Fig. 4: constant displacement; the force relaxes, eq. (16), the pressure keeps its shape, eq. (17)."""
    figure, (left, right) = panels(2)
    left.plot(TIME, setting.RELAXATION(TIME), color="black")
    left.axhline(setting.RELAXATION.equilibrium, color="grey", linewidth=0.8, linestyle="--")
    left.set(xlabel="$t$ [s]", ylabel="$N / N_e$", ylim=(0, 1.05), xlim=(0, 2))
    r = np.linspace(-1, 1, 401)
    for t, colour in zip(setting.CURVE_TIMES, shades(len(setting.CURVE_TIMES)), strict=True):
        p = pressure_after_step(np.abs(r), t, UNIT, 1.0, setting.K0, setting.RELAXATION)
        right.plot(r, p, color=colour, label=seconds(t))
    _label(right, "$r / a$", r"$p / \bar p_0$")
    letter(left, "a")
    letter(right, "b")
    return figure


def coupled_growth() -> Figure:
    """Fig. 5: constant load, the patch grows with ``k`` as eq. (25) couples them, ``k`` from 2 to 4."""
    figure, (ax,) = panels()
    exponents = np.array([2.0, 2.25, 2.5, 3.0, 3.5, 4.0])
    _grow(ax, exponents, radius_ratio(exponents, setting.K0), (f"$k = {k:g}$" for k in exponents))
    return figure


def creep() -> Figure:
    """Fig. 8: constant load, (a) the pressure flattens, eqs. (36), (22), (b) the radius grows, eq. (34)."""
    figure, (left, right) = panels(2)
    h = setting.CREEP(setting.CURVE_TIMES)
    k = exponent_after_creep(h, setting.K0).k
    _grow(left, k, np.sqrt(h), map(seconds, setting.CURVE_TIMES))
    right.plot(TIME, np.sqrt(setting.CREEP(TIME)), color="black")
    right.axhline(np.sqrt(setting.CREEP.equilibrium), color="grey", linewidth=0.8, linestyle="--")
    right.set(xlabel="$t$ [s]", ylabel="$a / a_0$", xlim=(0, 2), ylim=(1, 1.16))
    letter(left, "a")
    letter(right, "b")
    return figure


def _grow(ax: Axes, k: Floats, a: Floats, labels: Iterable[str]) -> None:
    r = np.linspace(-1, 1, 801)
    for k_i, a_i, label, colour in zip(k, a, labels, shades(len(k)), strict=True):
        ax.plot(a_i * r, pressure(a_i * np.abs(r), UNIT, a_i, k_i), color=colour, label=label)
    _label(ax, "$r / a_0$", r"$p / \bar p_0$")


def _label(ax: Axes, x: str, y: str) -> None:
    ax.set(xlabel=x, ylabel=y, ylim=(0, None))
    ax.legend(fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
