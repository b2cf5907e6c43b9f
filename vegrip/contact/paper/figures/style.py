"""How the figures look: white, thin grid, time running from dark to light."""

import math
from collections.abc import Sequence

from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure


def panels(count: int = 1, *, height: float = 3.4) -> tuple[Figure, list[Axes]]:
    """A figure with ``count`` panels side by side, and the panels."""
    figure = Figure(figsize=(4.6 * count, height), dpi=150, layout="constrained")
    axes = [figure.add_subplot(1, count, i + 1) for i in range(count)]
    for ax in axes:
        ax.grid(visible=True, linewidth=0.4, alpha=0.5)
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes


def shades(count: int) -> Sequence[tuple[float, float, float, float]]:
    """``count`` colours from dark to light, none too light to see on white."""
    return [colormaps["viridis"](0.85 * i / max(count - 1, 1)) for i in range(count)]


def seconds(t: float) -> str:
    """Label of the curve at time ``t`` [s]."""
    return r"$t \to \infty$" if math.isinf(t) else f"$t = {t:g}$ s"


def letter(ax: Axes, text: str) -> None:
    """Mark a panel as the paper does: (a), (b)."""
    ax.set_title(f"({text})", loc="left", fontsize=10)
