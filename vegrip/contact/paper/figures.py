"""The figures of the paper that show results, one function each, drawn with matplotlib (extra ``plot``).

White, with a thin grid; time runs from dark to light.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vegrip.contact.coupling import exponent_after_creep, radius_ratio
from vegrip.contact.limit_surface import reference
from vegrip.contact.paper import tables
from vegrip.contact.pressure import coefficient, coefficient_excess, pressure, pressure_after_step
from vegrip.errors import UsageError
from vegrip.types import Floats
from vegrip.whole_file import whole_file


def panels(count: int = 1, *, height: float = 3.4) -> tuple[Figure, list[Axes]]:
    """A figure with ``count`` panels side by side, and the panels."""
    figure = Figure(figsize=(4.6 * count, height), dpi=150, layout="constrained")
    axes = [figure.add_subplot(1, count, i + 1) for i in range(count)]
    for ax in axes:
        ax.grid(visible=True, linewidth=0.4, alpha=0.5)
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes


def shades(count: int) -> Sequence[tuple[float, float, float, float]]:
    return [colormaps["viridis"](0.85 * i / max(count - 1, 1)) for i in range(count)]


def seconds(t: float) -> str:
    """Label of the curve at time ``t`` [s]."""
    return r"$t \to \infty$" if math.isinf(t) else f"$t = {t:g}$ s"


def letter(ax: Axes, text: str) -> None:
    ax.set_title(f"({text})", loc="left", fontsize=10)


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
    left.plot(TIME, tables.RELAXATION(TIME), color="black")
    left.axhline(tables.RELAXATION.equilibrium, color="grey", linewidth=0.8, linestyle="--")
    left.set(xlabel="$t$ [s]", ylabel="$N / N_e$", ylim=(0, 1.05), xlim=(0, 2))
    r = np.linspace(-1, 1, 401)
    for t, colour in zip(tables.CURVE_TIMES, shades(len(tables.CURVE_TIMES)), strict=True):
        p = pressure_after_step(np.abs(r), t, UNIT, 1.0, tables.K0, tables.RELAXATION)
        right.plot(r, p, color=colour, label=seconds(t))
    _label(right, "$r / a$", r"$p / \bar p_0$")
    letter(left, "a")
    letter(right, "b")
    return figure


def coupled_growth() -> Figure:
    """Fig. 5: constant load, the patch grows with ``k`` as eq. (25) couples them, ``k`` from 2 to 4."""
    figure, (ax,) = panels()
    exponents = np.array([2.0, 2.25, 2.5, 3.0, 3.5, 4.0])
    _grow(ax, exponents, radius_ratio(exponents, tables.K0), (f"$k = {k:g}$" for k in exponents))
    return figure


def creep() -> Figure:
    """Fig. 8: constant load, (a) the pressure flattens, eqs. (36), (22), (b) the radius grows, eq. (34)."""
    figure, (left, right) = panels(2)
    h = tables.CREEP(tables.CURVE_TIMES)
    k = exponent_after_creep(h, tables.K0).k
    _grow(left, k, np.sqrt(h), map(seconds, tables.CURVE_TIMES))
    right.plot(TIME, np.sqrt(tables.CREEP(TIME)), color="black")
    right.axhline(np.sqrt(tables.CREEP.equilibrium), color="grey", linewidth=0.8, linestyle="--")
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


POINTS = {"linestyle": "none", "marker": "o", "markersize": 3.5, "color": "black", "fillstyle": "none"}
FIT_COLOUR = "tab:red"


def power_law() -> Figure:
    """Fig. 6: (a) ``ln(C_k - 1)`` is nearly straight in ``ln k``, eq. (37), (b) so eq. (38) fits ``C_k``."""
    figure, (left, right) = panels(2)
    fit = tables.fit_power()
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
    h = tables.CREEP(t)
    right.plot(t, tables.fit_power().exponent(h), color=FIT_COLOUR, label="eq. (40)")
    right.plot(
        t, exponent_after_creep(h, tables.K0).k, color="black", linestyle="--", label="eq. (4) inverted"
    )
    right.set(xlabel="$t$ [s]", ylabel="$k$", xlim=(0, 2), ylim=(1.9, 4.1))
    right.legend(fontsize=8, frameon=False, loc="lower right")
    letter(left, "a")
    letter(right, "b")
    return figure


def radius_fit() -> Figure:
    """Fig. 12: ``1 / sqrt(C_k)`` against the weighted least squares fit, eq. (64)."""
    figure, (ax,) = panels()
    fit = tables.fit_radius()
    k = tables.CANONICAL_K
    ax.plot(k, 1 / np.sqrt(coefficient(k)), label=r"$1 / \sqrt{C_k}$, eq. (4)", **POINTS)  # type: ignore[arg-type]
    label = f"eq. (64), $1 - {fit.A:.3f}\\,e^{{-{fit.B:.3f} k}}$"
    ax.plot(k, fit.inverse_root(k), color=FIT_COLOUR, label=label)
    ax.set(xlabel="$k$", ylabel=r"$1 / \sqrt{C_k}$")
    ax.legend(fontsize=8, frameon=False)
    return figure


DISTANCES = np.tan(np.linspace(0, 0.499 * np.pi, 120))  # of the COR, from pure torsion to nearly pure force


def constant_area() -> Figure:
    """Fig. 9: displacement held; the surface keeps its shape and shrinks with the force, eqs. (49), (50)."""
    figure, (ax,) = panels(height=3.8)
    f, m = reference.point(tables.K0, DISTANCES)
    for t, colour in zip(tables.CURVE_TIMES, shades(len(tables.CURVE_TIMES)), strict=True):
        g = float(tables.RELAXATION(t))
        ax.plot(g * f, g * m, color=colour, label=f"{seconds(t)}, $N = {g:.2f}\\,N_0$")
    _label_loads(ax, r"$f_t\,/\,(\mu N_0)$", r"$m_n\,/\,(\mu N_0 a)$")
    return figure


def constant_load() -> Figure:
    """Fig. 10: load held; force stays, torque grows with patch and profile, eqs. (51), (52)."""
    figure, (ax,) = panels(height=3.8)
    for t, colour in zip(tables.CURVE_TIMES, shades(len(tables.CURVE_TIMES)), strict=True):
        k, f, m = tables.crept_surface(t, DISTANCES)
        ax.plot(f, m, color=colour, label=f"{seconds(t)}, $k = {k:.2f}$")
    _label_loads(ax, r"$f_t\,/\,(\mu N_0)$", r"$m_n\,/\,(\mu N_0 a_0)$")
    return figure


def _label_loads(ax: Axes, x: str, y: str) -> None:
    ax.set(xlabel=x, ylabel=y, xlim=(0, 1.05), ylim=(0, None))
    ax.legend(fontsize=7, frameon=False, loc="lower left")


FIGURES: dict[str, Callable[[], Figure]] = {
    "fig02": profiles,
    "fig04": relaxation,
    "fig05": coupled_growth,
    "fig06": power_law,
    "fig07": exponent,
    "fig08": creep,
    "fig09": constant_area,
    "fig10": constant_load,
    "fig12": radius_fit,
}


def save_all(folder: Path) -> list[Path]:
    """Draw every figure as PNG into ``folder``, which is made when it is missing; return the files."""
    files = [folder / f"{name}.png" for name in FIGURES]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for file in files:
            with whole_file(file) as part:
                FIGURES[file.stem]().savefig(part)
    except OSError as error:
        raise UsageError(f"cannot write figures into {folder}: {error.strerror}") from None
    return files
