"""Pictures of a comparison: measured and modelled, what is left in order, over depth and over time."""

from pathlib import Path
from typing import Any, Final

import numpy as np

from vegrip.identification.compare.comparison import Comparison, residuals_of
from vegrip.identification.compare.features import PHASES
from vegrip.identification.compare.where import Residuals
from vegrip.identification.compare.words import SPOKEN_UNITS
from vegrip.identification.recording import Recording
from vegrip.plotting import new_figure, save_figure
from vegrip.types import Floats

PAUSE_DRAWN_S: Final = 0.5  # [s] that is drawn between trials
TIME_LABEL: Final = "time without the pauses [s]"


def drawn_time(recording: Recording) -> Floats:
    """Return the time [s] with every pause between trials as short as :data:`PAUSE_DRAWN_S`."""
    steps = np.diff(recording.t, prepend=recording.t[0])
    steps[np.flatnonzero(np.diff(recording.episode) != 0) + 1] = PAUSE_DRAWN_S
    drawn: Floats = np.cumsum(steps)
    return drawn


def draw_comparison(comparison: Comparison, folder: Path, name: str = "model") -> list[Path]:
    """Draw one picture per channel into ``folder``; return the files. ``name`` is that of the model.

    Raises:
        UsageError: matplotlib is not installed.
        InputError: the picture cannot be written.

    """
    folder.mkdir(parents=True, exist_ok=True)
    features = comparison.features
    files = []
    for residuals in residuals_of(comparison.problem, comparison.u):
        figure, every = new_figure(4, size=(9, 10))
        t = drawn_time(comparison.problem.measured.recording)[residuals.rows]
        _measured(every[0], comparison, residuals, t, name)
        axes = every[1:]
        axes[0].plot(t, residuals.z, ".", ms=1.5)
        _labels(axes[0], TIME_LABEL, "residual / std")
        every[0].set_title(f"{comparison.problem.measured.recording.name}: {residuals.channel}, {name}")
        depth = 1e3 * features.values["indentation"][residuals.rows]
        phase = features.phase[residuals.rows]
        for p in np.unique(phase):
            axes[1].plot(depth[phase == p], residuals.z[phase == p], ".", ms=1.5, label=PHASES[p])
        axes[1].legend(markerscale=5, fontsize=7, ncols=3)
        _labels(axes[1], "displacement [mm]", "residual / std")
        axes[2].semilogx(
            np.maximum(features.values["time_in_contact"][residuals.rows], 1e-3), residuals.z, ".", ms=1.5
        )
        _labels(axes[2], "time in contact [s]", "residual / std")
        files.append(folder / f"{residuals.channel}.png")
        save_figure(figure, files[-1])
    return files


def measured_values(comparison: Comparison, residuals: Residuals) -> Floats:
    """Return the measurements in the rows of ``residuals``; of loads at slip the sizes."""
    columns = comparison.problem.measured.columns
    if residuals.channel == "tangential_force":
        none = np.zeros(columns["t"].size)
        size: Floats = np.hypot(*(columns.get(f"tangential_force_{i}", none)[residuals.rows] for i in "xy"))
        return size
    seen: Floats = columns[residuals.channel][residuals.rows]
    return seen if residuals.channel == "normal_force" else np.abs(seen)


def _measured(axis: Any, comparison: Comparison, residuals: Residuals, t: Floats, name: str) -> None:
    """Draw measurement and model."""
    seen = measured_values(comparison, residuals)
    axis.plot(t, seen, "k.", ms=1.5, label="measured")
    axis.plot(t, seen - residuals.raw, ".", ms=1.0, label=name)
    axis.legend(markerscale=5, fontsize=7)
    axis.set_xlabel(TIME_LABEL)
    axis.set_ylabel(f"{residuals.channel.replace('_', ' ')} [{SPOKEN_UNITS[residuals.channel]}]")


def _labels(axis: Any, x: str, y: str) -> None:
    axis.axhspan(-1.96, 1.96, color="0.9")
    axis.set_xlabel(x)
    axis.set_ylabel(y)
