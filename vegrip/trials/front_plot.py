"""The picture of fronts: share of trials with a slip against force over least possible force."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from vegrip.plotting import save_figure

COLOURS = {
    "vegrip": "#0b6e4f", "learning": "#b8336a", "known": "#222222",
    "ellipse": "#7fb69f", "constant": "#8a8a8a",
    "cone": "#d1603d", "elastic": "#4a7bd0",
}  # fmt: skip


def draw_fronts(told: Mapping[str, Any], grasp: str, path: Path) -> None:
    """Write the picture of the fronts of ``told`` (as ``vegrip controllers --json`` has them) to ``path``."""
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axes = figure.subplots()
    for name, one in told.items():
        front = one["front"]
        colour = COLOURS.get(name, "#000000")
        across = [point["force_over_least"] for point in front]
        up = [100.0 * point["trials_with_slip"] / point["trials"] for point in front]
        axes.plot(across, up, "o-", color=colour, markersize=4, linewidth=1.2, label=name)
        point = next(point for point in front if point["knob"] == one["knob"])
        at = point["force_over_least"], 100.0 * point["trials_with_slip"] / point["trials"]
        low, high = (100.0 * bound for bound in point["slip_probability_bounds"])
        axes.errorbar(
            *at, yerr=[[at[1] - low], [high - at[1]]], color=colour, capsize=3, linewidth=0.8, alpha=0.6
        )
        axes.plot(*at, "s", color=colour, markersize=10, fillstyle="none", markeredgewidth=1.6)
    axes.axvline(1.0, color="black", linewidth=0.8)
    axes.set_xlabel("grip force over the least possible force [-]")
    axes.set_ylabel("trials with a slip [%]")
    axes.set_xlim(left=0.95)
    axes.set_ylim(bottom=-1.0)
    axes.grid(alpha=0.25)
    axes.set_title(f"{grasp}: every controller over its knob; squares: operating points with 95 % intervals")
    axes.legend(frameon=False)
    save_figure(figure, path, dpi=140)
