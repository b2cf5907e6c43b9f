"""A picture of one finger: what was measured, and what the node said of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.folder import read_recording
from vegrip.identification.recording.session import read_output
from vegrip.plotting import new_figure, save_figure

Array = NDArray[Any]
MEASURED, ESTIMATED, BOUND = "0.45", "C0", "C3"


@dataclass(frozen=True)
class Estimates:
    """What is drawn of one finger."""

    measured: Recording
    contact: dict[str, Array]
    margin: dict[str, Array]
    command: dict[str, Array]
    health: dict[str, Array]


def read_estimates(folder: Path) -> Estimates:
    """Read one finger's folder of a session; what the node never said is empty."""
    files = (folder / f"{name}.csv" for name in ("contact", "slip_margin", "force_command", "model_health"))
    tables = (read_output(file) if file.exists() else {} for file in files)
    return Estimates(read_recording(folder, announce=False), *tables)


def draw_replay(folder: Path, picture: Path, title: str) -> None:
    """Draw the finger recorded in ``folder`` of a session to ``picture``."""
    estimates = read_estimates(folder)
    panels: list[Callable[[Any, Estimates], None]] = [_force, _error, _depth, _radius, _nis]
    if np.any(~np.isnan(estimates.margin.get("margin", np.array([np.nan])))):
        panels.append(_margin)
    figure, axes = new_figure(len(panels), size=(9, 2.1 * len(panels)), share_x=True)
    for axis, panel in zip(axes, panels, strict=True):
        panel(axis, estimates)
        axis.grid(alpha=0.3)
    axes[0].set_title(title, loc="left")
    axes[-1].set_xlabel("time [s]")
    save_figure(figure, picture)


def _force(axis: Any, estimates: Estimates) -> None:
    measured = estimates.measured.columns.get("normal_force", np.empty(0))
    scale, prefix = engineering(measured)
    if len(measured):
        axis.plot(estimates.measured.t, measured * scale, ".", ms=2, color=MEASURED, label="measured")
    _band(axis, estimates.contact, "normal_force", scale, "estimated, 2 std")
    axis.set_ylabel(f"normal force [{prefix}N]")
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize="small", frameon=False)


def _error(axis: Any, estimates: Estimates) -> None:
    measured = estimates.measured.columns.get("normal_force", np.empty(0))
    if len(measured) and "normal_force" in estimates.contact:
        t = estimates.contact["t"]
        error = estimates.contact["normal_force"] - np.interp(t, estimates.measured.t, measured)
        scale, prefix = engineering(error)
        axis.plot(*broken(t, error * scale), color=ESTIMATED, lw=1)
        axis.set_ylabel(f"estimated - measured\n[{prefix}N]")
    axis.axhline(0.0, color="k", lw=0.8, ls="--")


def _depth(axis: Any, estimates: Estimates) -> None:
    measured = estimates.measured.columns.get("displacement", np.empty(0))
    estimated = estimates.contact.get("indentation", np.empty(0))
    scale, prefix = engineering(measured if len(measured) else estimated)
    if len(measured):
        axis.plot(estimates.measured.t, measured * scale, ".", ms=2, color=MEASURED, label="measured")
    _band(axis, estimates.contact, "indentation", scale, "estimated, 2 std")
    axis.set_ylabel(f"indentation [{prefix}m]")


def _radius(axis: Any, estimates: Estimates) -> None:
    radius = estimates.contact.get("contact_radius", np.empty(0))
    scale, prefix = engineering(radius)
    _band(axis, estimates.contact, "contact_radius", scale, "a, 2 std")
    axis.set_ylabel(f"contact radius [{prefix}m]")
    if np.any(radius > 0.0):
        axis.set_ylim(0.0, 1.2 * scale * np.nanmax(radius))
    other = axis.twinx()
    if "pressure_exponent" in estimates.contact:
        trusted = estimates.contact["pressure_exponent_valid"] > 0
        k = np.where(trusted, estimates.contact["pressure_exponent"], np.nan)
        other.plot(*broken(estimates.contact["t"], k), color=BOUND, lw=1)
        # at a vanishing contact k runs away; that is not what the axis is for
        other.set_ylim(1.5, 1.2 * max(4.0, np.nanpercentile(k, 95)) if np.any(trusted) else 5.0)
    other.set_ylabel("pressure exponent k", color=BOUND)


def _nis(axis: Any, estimates: Estimates) -> None:
    if "nis" in estimates.health:
        axis.plot(*broken(estimates.health["t"], estimates.health["nis"]), color=ESTIMATED, lw=1)
    axis.axhline(1.0, color="k", lw=0.8, ls="--")
    axis.set_yscale("log")
    axis.set_ylabel("NIS\n(1: consistent)")


def _margin(axis: Any, estimates: Estimates) -> None:
    _band(axis, estimates.margin, "margin", 1.0, "margin, 2 std")
    axis.plot(
        *broken(estimates.margin["t"], estimates.margin["lower_bound"]),
        color=BOUND,
        lw=1,
        label="lower bound",
    )
    axis.set_ylim(-0.2, 1.05)
    axis.set_ylabel("slip margin")
    axis.legend(loc="lower left", fontsize="small")


def _band(axis: Any, table: dict[str, Array], name: str, scale: float, label: str) -> None:
    if name not in table:
        return
    t, value, std = table["t"], table[name] * scale, table[f"{name}_std"] * scale
    trusted = (table[f"{name}_valid"] > 0) & np.isfinite(std)
    spread = np.where(trusted, 2.0 * std, np.nan)
    axis.plot(*broken(t, value), color=ESTIMATED, lw=1, label=label)
    axis.fill_between(*broken(t, value - spread, value + spread), color=ESTIMATED, alpha=0.25, lw=0)


def broken(t: Array, *curves: Array) -> tuple[Array, ...]:
    """Return ``t`` and ``curves`` with a NaN in every gap, so that no line is drawn where nothing was."""
    if len(t) < 3:
        return t, *curves
    steps = np.diff(t)
    gaps = np.flatnonzero(steps > max(20.0 * np.median(steps), 0.3)) + 1
    return tuple(np.insert(values.astype(np.float64), gaps, np.nan) for values in (t, *curves))


def engineering(values: Array) -> tuple[float, str]:
    """Return factor and prefix that bring the largest of ``values`` to 1 .. 1000."""
    largest = float(np.nanmax(np.abs(values))) if np.any(np.isfinite(values)) else 0.0
    for exponent, prefix in ((0, ""), (-3, "m"), (-6, "µ"), (-9, "n")):
        if largest >= 10.0**exponent or exponent == -9:
            return 10.0**-exponent, prefix
    return 1.0, ""
