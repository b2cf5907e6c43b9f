"""A comparison as pictures and as curves to draw: measured and modelled, what is left by time and regime.

Long recordings are thinned to columns that keep the smallest and the greatest value, so no peak is lost.
"""

from pathlib import Path
from typing import Any, Final

import numpy as np

from vegrip.identification.compare.comparison import Comparison, residuals_of
from vegrip.identification.compare.where import MIN_REGIME_ROWS, PHASES, SPOKEN_UNITS, Features, Residuals
from vegrip.identification.fit.problem import Problem
from vegrip.identification.recording import Recording
from vegrip.plotting import new_figure, save_figure
from vegrip.types import Floats

PAUSE_DRAWN_S: Final = 0.5  # [s] that is drawn between trials
TIME_LABEL: Final = "time without the pauses [s]"
COLUMNS: Final = 420
BINS: Final = 12
VARIABLES: Final = ("indentation", "normal_force", "speed", "time_in_contact", "time", "temperature")


def drawn_time(recording: Recording) -> Floats:
    """Return the time [s] with every pause between trials as short as :data:`PAUSE_DRAWN_S`."""
    steps = np.diff(recording.t, prepend=recording.t[0])
    steps[np.flatnonzero(np.diff(recording.episode) != 0) + 1] = PAUSE_DRAWN_S
    drawn: Floats = np.cumsum(steps)
    return drawn


def draw_comparison(comparison: Comparison, folder: Path, name: str = "model") -> list[Path]:
    """Draw one picture per channel into ``folder``; return the files. ``name`` is that of the model."""
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


def measured_values(problem: Problem, residuals: Residuals) -> Floats:
    """Return the measurements in the rows of ``residuals``; of loads at slip the sizes."""
    columns = problem.measured.columns
    if residuals.channel == "tangential_force":
        none = np.zeros(columns["t"].size)
        size: Floats = np.hypot(*(columns.get(f"tangential_force_{i}", none)[residuals.rows] for i in "xy"))
        return size
    seen: Floats = columns[residuals.channel][residuals.rows]
    return seen if residuals.channel == "normal_force" else np.abs(seen)


def _measured(axis: Any, comparison: Comparison, residuals: Residuals, t: Floats, name: str) -> None:
    seen = measured_values(comparison.problem, residuals)
    axis.plot(t, seen, "k.", ms=1.5, label="measured")
    axis.plot(t, seen - residuals.raw, ".", ms=1.0, label=name)
    axis.legend(markerscale=5, fontsize=7)
    axis.set_xlabel(TIME_LABEL)
    axis.set_ylabel(f"{residuals.channel.replace('_', ' ')} [{SPOKEN_UNITS[residuals.channel]}]")


def _labels(axis: Any, x: str, y: str) -> None:
    axis.axhspan(-1.96, 1.96, color="0.9")
    axis.set_xlabel(x)
    axis.set_ylabel(y)


def curves(comparison: Comparison) -> dict[str, Any]:
    """Return, by channel, ``columns`` over time, ``phases`` and ``variables`` with the residual in each.

    Residuals are standardised: in units of the noise, measured less modelled.
    """
    time = drawn_time(comparison.problem.measured.recording)
    features = comparison.features
    noise = {name: one.noise for name, one in comparison.channels.items()}
    found = {}
    for residuals in residuals_of(comparison.problem, comparison.u):
        measured = measured_values(comparison.problem, residuals)
        found[residuals.channel] = {
            "unit": SPOKEN_UNITS[residuals.channel],
            "noise": noise.get(residuals.channel),
            "columns": _columns(time[residuals.rows], measured, residuals),
            "phases": _phases(residuals, features),
            "variables": {
                name: {"unit": SPOKEN_UNITS.get(name, ""), "bins": bins}
                for name in VARIABLES
                if name in features.values and (bins := _bins(residuals, features.values[name]))
            },
        }
    return found


def _columns(time: Floats, measured: Floats, residuals: Residuals) -> dict[str, list[float]]:
    if not time.size:
        return {}
    edges = np.linspace(time[0], time[-1], COLUMNS + 1)
    place = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, COLUMNS - 1)
    order = np.argsort(place, kind="stable")
    starts = np.flatnonzero(np.diff(place[order], prepend=-1))
    counts = np.diff(starts, append=order.size)
    model = measured - residuals.raw

    def least(values: Floats) -> list[float]:
        return _short(np.minimum.reduceat(values[order], starts))

    def greatest(values: Floats) -> list[float]:
        return _short(np.maximum.reduceat(values[order], starts))

    return {
        "time": _short(np.add.reduceat(time[order], starts) / counts),
        "measured_low": least(measured),
        "measured_high": greatest(measured),
        "model_low": least(model),
        "model_high": greatest(model),
        "z_low": least(residuals.z),
        "z_high": greatest(residuals.z),
    }


def _phases(residuals: Residuals, features: Features) -> list[dict[str, Any]]:
    phase = features.phase[residuals.rows]
    return [
        {"name": name, **_summary(residuals.z[phase == i])}
        for i, name in enumerate(PHASES)
        if np.count_nonzero(phase == i) >= MIN_REGIME_ROWS
    ]


def _bins(residuals: Residuals, values: Floats) -> list[dict[str, Any]]:
    """Return the residual in bins of equally many rows; none where the variable does not vary."""
    here = values[residuals.rows]
    if here.size < BINS * MIN_REGIME_ROWS:
        return []
    edges = np.unique(np.quantile(here, np.linspace(0.0, 1.0, BINS + 1)))
    place = np.clip(np.searchsorted(edges, here, side="right") - 1, 0, edges.size - 2)
    return [
        {
            "low": float(f"{edges[i]:.4g}"),
            "high": float(f"{edges[i + 1]:.4g}"),
            **_summary(residuals.z[place == i]),
        }
        for i in range(edges.size - 1)
        if np.count_nonzero(place == i) >= MIN_REGIME_ROWS
    ]


def _summary(z: Floats) -> dict[str, float | int]:
    return {
        "rows": int(z.size),
        "mean": float(f"{np.mean(z):.3g}"),
        "rms": float(f"{np.sqrt(np.mean(z**2)):.3g}"),
        "excess": float(f"{np.sum(z**2 - 1.0):.4g}"),  # that noise does not explain
    }


def _short(values: Floats) -> list[float]:
    return [float(f"{value:.4g}") for value in values]
