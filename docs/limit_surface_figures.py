"""Draw the figure of docs/limit-surface.md and print the numbers it quotes.

Run it with ``.venv/bin/python docs/limit_surface_figures.py``.
"""

import json
import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vegrip.contact.limit_surface import fast, reference
from vegrip.contact.limit_surface.pressure_map import PressureMap, bound_gauge
from vegrip.contact.paper.figures import panels
from vegrip.types import Floats

IMAGES = Path(__file__).parent / "images"
SLIP_CENTRES = np.tan(np.linspace(1e-3, np.pi / 2 - 1e-3, 800))
EXPONENTS = {1.0: "tab:purple", 2.0: "black", 4.0: "tab:blue", np.inf: "tab:green"}


def main() -> None:
    """Draw and print everything; ``--json``: the figure of the first page alone, and no picture."""
    if "--json" in sys.argv[1:]:
        sys.stdout.write(json.dumps({"outside": short_of_ellipse(2)}) + "\n")
        return
    figure, (left, right) = panels(2)
    draw_surfaces(left)
    draw_errors(right)
    save(figure, IMAGES / "limit-surface.png")
    k, d = np.meshgrid(np.append(1 / np.linspace(0.02, 1, 80), [100, 1e4, np.inf]), SLIP_CENTRES)
    error = radius_error(k, d)
    say("fast radius, outside by at most", error.max())
    say("fast radius, inside by at most", -error.min())
    for k in (2, 3, 4, 8):
        say(f"surface short of the ellipse, k = {k}, at most", short_of_ellipse(k))
    feet = PressureMap([[-1, -1], [2, -1], [-1, 2]], [1, 1, 1])
    bounds = bound_gauge(feet, [0.3, 0.2, 0.5])
    say("gauge of a load on three feet, lower bound", bounds.lower)
    say("gauge of a load on three feet, upper bound", bounds.upper)


def short_of_ellipse(k: float) -> float:
    """Return by which share of it the ellipse lies at most outside of the surface."""
    f, m = reference.point(k, SLIP_CENTRES)
    return float(np.max(1 - np.hypot(f, m / reference.torsion_limit(k))))


def draw_surfaces(axes: Axes) -> None:
    """Surfaces of four exponents, and the ellipse of k = 2."""
    for k, colour in EXPONENTS.items():
        f, m = reference.point(k, SLIP_CENTRES)
        axes.plot(f, m, color=colour, label=rf"$k = {k:g}$" if np.isfinite(k) else r"$k = \infty$")
    angle = np.linspace(0, np.pi / 2, 200)
    axes.plot(
        np.cos(angle),
        reference.torsion_limit(2) * np.sin(angle),
        "--",
        color="tab:red",
        label="ellipse, $k = 2$",
    )
    axes.set(xlabel=r"$f = |f_t|/(\mu N)$", ylabel=r"$m = |m_n|/(\mu N a)$", xlim=(0, 1.02), ylim=(0, 0.7))
    axes.legend(frameon=False, loc="lower left")


def draw_errors(axes: Axes) -> None:
    """Error of the fast radius over the load angle, negative on the safe side."""
    for k, colour in EXPONENTS.items():
        f, m = reference.point(k, SLIP_CENTRES)
        error = radius_error(np.full_like(f, k), SLIP_CENTRES)
        axes.plot(np.degrees(np.arctan2(m, f)), 1e6 * error, color=colour)
    axes.axhline(0, color="0.6", linewidth=0.8)
    axes.set(xlabel=r"load angle $\psi$ [deg]", ylabel=r"error of the radius [$10^{-6}$]", xlim=(0, 90))


def radius_error(k: Floats, d: Floats) -> Floats:
    """Relative error of the fast radius at the points of the slip centres d: positive is outside, unsafe."""
    f, m = reference.point(k, d)
    return 1 / fast.gauges(k.ravel(), f.ravel(), m.ravel()).reshape(f.shape) - 1


def save(figure: Figure, path: Path) -> None:
    """Write a picture and say so."""
    figure.savefig(path, dpi=130)
    sys.stdout.write(f"{path.name}\n")


def say(what: str, value: float) -> None:
    """Print one number of the page."""
    sys.stdout.write(f"  {what}: {value:.10g}\n")


if __name__ == "__main__":
    main()
