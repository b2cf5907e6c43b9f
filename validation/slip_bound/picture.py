"""The reliability diagram: how often the bound holds, over how often it should."""

from pathlib import Path
from typing import Any

from vegrip.plotting import new_figure, save_figure

PARTS = {
    "no slip channel": (), "slip channel": ("with_slip_channel",),
    "slip channel, after a slide": ("after_a_slide",),
}  # fmt: skip


def draw(worlds: dict[str, dict[str, Any]], picture: Path) -> None:
    """Draw a panel for each world; below the dashed line the bound holds less often than it says."""
    figure, panels = new_figure(len(worlds), size=(6.0, 4.2 * len(worlds)), share_x=True)
    for axes, (world, told) in zip(panels, worlds.items(), strict=True):
        axes.plot([50, 100], [50, 100], "k--", lw=1, label="as stated")
        for name, keys in PARTS.items():
            part = told[keys[0]] if keys else told
            axes.plot(*curve(part), "o-", ms=4, lw=1.5, label=name)
        for name, part in told["by_class"].items():
            axes.plot(*curve(part), lw=0.8, alpha=0.6, label=f"{name}, no slip channel")
        axes.set_title(f"{world} world, {told['grasps']} grasps")
        axes.set_ylabel("grasps whose bound held at every look [%]")
        axes.grid(alpha=0.3)
        axes.legend(fontsize="x-small", loc="lower right")
    panels[-1].set_xlabel("stated confidence [%]")
    save_figure(figure, picture)


def curve(told: dict[str, Any]) -> tuple[list[float], list[float]]:
    """Return stated confidence and share of grasps whose bound held [%]."""
    missed = told["margin_below_bound"]
    return [100.0 * float(name) for name in missed], [100.0 * (1.0 - share) for share in missed.values()]
