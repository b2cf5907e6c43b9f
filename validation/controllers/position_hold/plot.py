"""The picture of the study: holds that slip, and tightenings, against force over least possible force."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from validation.controllers.position_hold.study import Fronts
from vegrip.plotting import save_figure

STYLES = {
    "elastic": ("#6e6e6e", "o", "--", "elastic surface, a constant on top"),
    "last ratio": ("#d55e00", "^", "-.", "what the last hold lost, a constant on top"),
    "forecast": ("#0072b2", "s", "-", "vegrip: forecast of the end of the hold"),
    "elastic, again": ("#6e6e6e", "o", "--", "elastic surface, tightens when the force is low"),
    "forecast, again": ("#0072b2", "s", "-", "vegrip: forecast, tightens before it slips"),
}
"""Colour, marker, line, name; told apart by every colour vision, and in grey."""
ONCE, AGAIN = ("elastic", "last ratio", "forecast"), ("elastic, again", "forecast, again")


def draw_fronts(fronts: Fronts, path: Path) -> None:
    """Write the picture of ``fronts`` to ``path``."""
    figure = Figure(figsize=(13.0, 5.6), layout="constrained")
    figure.suptitle("A gripper that holds position for about a minute, pads of unknown material", fontsize=14)
    first, second, again = figure.subplots(1, 3)
    _draw_slips(first, fronts["first hold"], ("elastic", "forecast"))
    first.set_title("closed once, material never met", fontsize=11)
    _draw_slips(second, fronts["second hold"], ONCE)
    second.set_title("closed once, second hold of the same pads", fontsize=11)
    _draw_tightenings(again, fronts["first hold"])
    again.set_title("may tighten again, material never met", fontsize=11)
    limit = max(axes.get_xlim()[1] for axes in (first, second, again))
    for axes in (first, second, again):
        axes.set_xlim(0.85, limit)
        axes.set_xlabel("mean force over the least possible [-]")
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    handles: dict[str, Artist] = {}
    for axes in (first, second, again):
        handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=3, frameon=False)
    save_figure(figure, path, dpi=140)


def _draw_slips(axes: Axes, rules: Mapping[str, list[dict[str, Any]]], names: tuple[str, ...]) -> None:
    for name in names:
        points = sorted(rules[name], key=lambda point: float(point["force_over_least"]))
        colour, marker, line, label = STYLES[name]
        across = [point["force_over_least"] for point in points]
        up = [100.0 * point["slipped"] / point["holds"] for point in points]
        axes.plot(across, up, line, marker=marker, color=colour, markersize=6, label=label, clip_on=False)
    _draw_known(axes, rules)
    axes.set_ylim(0.0, 100.0)
    axes.set_ylabel("holds that slip [%]")


def _draw_tightenings(axes: Axes, rules: Mapping[str, list[dict[str, Any]]]) -> None:
    for name in AGAIN:
        points = sorted(rules[name], key=lambda point: float(point["force_over_least"]))
        colour, marker, line, label = STYLES[name]
        across = [point["force_over_least"] for point in points]
        up = [point["tightenings"] for point in points]
        axes.plot(across, up, line, color=colour, marker=marker, markersize=6, label=label)
        for x, y, point in zip(across, up, points, strict=True):
            if point["slipped"]:
                share = 100.0 * point["slipped"] / point["holds"]
                axes.annotate(
                    f"{share:.0f} % slip", (x, y), xytext=(-14, -16), textcoords="offset points", fontsize=8
                )
    _draw_known(axes, rules)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("tightenings in a hold [-]")


def _draw_known(axes: Axes, rules: Mapping[str, list[dict[str, Any]]]) -> None:
    known = next(iter(rules.values()))[0]["known_over_least"]
    axes.axvline(known, color="black", linewidth=1.0, linestyle=":", label="closed once, everything known")
