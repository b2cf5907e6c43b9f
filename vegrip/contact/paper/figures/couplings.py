"""Figs. 6, 7, 12: the coefficient of the pressure profile and the paper's fits to it."""

import numpy as np
from matplotlib.figure import Figure

from vegrip.contact.coupling import exponent_after_creep
from vegrip.contact.coupling_fits import CANONICAL_K, fit_power, fit_radius
from vegrip.contact.paper import setting
from vegrip.contact.paper.figures.style import letter, panels
from vegrip.contact.pressure import coefficient, coefficient_excess

POINTS = {"linestyle": "none", "marker": "o", "markersize": 3.5, "color": "black", "fillstyle": "none"}
FIT_COLOUR = "tab:red"


def power_law() -> Figure:
    """Fig. 6: (a) ``ln(C_k - 1)`` is nearly straight in ``ln k``, eq. (37), (b) so eq. (38) fits ``C_k``."""
    figure, (left, right) = panels(2)
    fit = fit_power()
    k, fine = np.linspace(1, 10, 37), np.linspace(1, 10, 400)
    left.plot(np.log(k), np.log(coefficient_excess(k)), label="eq. (4)", **POINTS)  # type: ignore[arg-type]
    left.plot(np.log(fine), np.log(fit.A) + fit.B * np.log(fine), color=FIT_COLOUR, label="eq. (37)")
    left.set(xlabel=r"$\ln k$", ylabel=r"$\ln (C_k - 1)$")
    right.plot(k, coefficient(k), label="eq. (4)", **POINTS)  # type: ignore[arg-type]
    right.plot(
        fine,
        fit.coefficient(fine),
        color=FIT_COLOUR,
        label=f"eq. (38), $1 + {fit.A:.3f}\\,k^{{{fit.B:.3f}}}$",
    )
    right.set(xlabel="$k$", ylabel="$C_k$", ylim=(0.9, 3.1))
    for ax, name in ((left, "a"), (right, "b")):
        ax.legend(fontsize=8, frameon=False)
        letter(ax, name)
    return figure


def exponent() -> Figure:
    """Fig. 7: (a) ``C_k`` of eq. (4), (b) ``k`` while the contact creeps, by eq. (40) and without its fit."""
    figure, (left, right) = panels(2)
    k = np.linspace(1, 10, 200)
    left.plot(k, coefficient(k), color="black")
    left.set(xlabel="$k$", ylabel="$C_k$", xlim=(1, 10), ylim=(0.9, 3.1))
    t = np.linspace(0, 2, 201)
    h = setting.CREEP(t)
    right.plot(t, fit_power().exponent(h), color=FIT_COLOUR, label="eq. (40)")
    right.plot(
        t, exponent_after_creep(h, setting.K0).k, color="black", linestyle="--", label="eq. (4) inverted"
    )
    right.set(xlabel="$t$ [s]", ylabel="$k$", xlim=(0, 2), ylim=(1.9, 4.1))
    right.legend(fontsize=8, frameon=False, loc="lower right")
    letter(left, "a")
    letter(right, "b")
    return figure


def radius_fit() -> Figure:
    """Fig. 12: ``1 / sqrt(C_k)`` against the weighted least squares fit, eq. (64)."""
    figure, (ax,) = panels()
    fit = fit_radius()
    k = CANONICAL_K
    ax.plot(k, 1 / np.sqrt(coefficient(k)), label=r"$1 / \sqrt{C_k}$, eq. (4)", **POINTS)  # type: ignore[arg-type]
    label = f"eq. (64), $1 - {fit.A:.3f}\\,e^{{-{fit.B:.3f} k}}$"
    ax.plot(k, fit.inverse_root(k), color=FIT_COLOUR, label=label)
    ax.set(xlabel="$k$", ylabel=r"$1 / \sqrt{C_k}$")
    ax.legend(fontsize=8, frameon=False)
    return figure
