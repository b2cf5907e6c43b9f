"""Figs. 9, 10: the friction limit surface shrinks at constant area and grows at constant load."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vegrip.contact.limit_surface import reference
from vegrip.contact.paper import setting
from vegrip.contact.paper.figures.style import panels, seconds, shades
from vegrip.contact.paper.tables import crept_surface

DISTANCES = np.tan(np.linspace(0, 0.499 * np.pi, 120))  # of the COR, from pure torsion to nearly pure force


def constant_area() -> Figure:
    """Fig. 9: displacement held; the surface keeps its shape and shrinks with the force, eqs. (49), (50)."""
    figure, (ax,) = panels(height=3.8)
    f, m = reference.point(setting.K0, DISTANCES)
    for t, colour in zip(setting.CURVE_TIMES, shades(len(setting.CURVE_TIMES)), strict=True):
        g = float(setting.RELAXATION(t))
        ax.plot(g * f, g * m, color=colour, label=f"{seconds(t)}, $N = {g:.2f}\\,N_0$")
    _label(ax, r"$f_t\,/\,(\mu N_0)$", r"$m_n\,/\,(\mu N_0 a)$")
    return figure


def constant_load() -> Figure:
    """Fig. 10: load held; force stays, torque grows with patch and profile, eqs. (51), (52)."""
    figure, (ax,) = panels(height=3.8)
    for t, colour in zip(setting.CURVE_TIMES, shades(len(setting.CURVE_TIMES)), strict=True):
        k, f, m = crept_surface(t, DISTANCES)
        ax.plot(f, m, color=colour, label=f"{seconds(t)}, $k = {k:.2f}$")
    _label(ax, r"$f_t\,/\,(\mu N_0)$", r"$m_n\,/\,(\mu N_0 a_0)$")
    return figure


def _label(ax: Axes, x: str, y: str) -> None:
    ax.set(xlabel=x, ylabel=y, xlim=(0, 1.05), ylim=(0, None))
    ax.legend(fontsize=7, frameon=False, loc="lower left")
