"""A comparison as pictures and as curves to draw: measured and modelled, what is left by time and regime.

Long recordings are thinned to columns that keep the smallest and the greatest value, so no peak is lost.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vegrip.identification.compare.comparison import Comparison, residuals_of
from vegrip.identification.compare.where import MIN_REGIME_ROWS, PHASES, SPOKEN_UNITS, Features, Residuals
from vegrip.identification.fit.problem import Problem
from vegrip.identification.recording import Recording
from vegrip.plotting import empty_figure, runs, save_figure
from vegrip.types import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAUSE_DRAWN_S: Final = 0.5  # [s] that is drawn between trials
TIME_LABEL: Final = "time without the pauses [s]"
COLUMNS: Final = 420
BINS: Final = 12
IN_A_ROW: Final = 3  # pictures over a variable
SIGMA: Final = 1.96  # standard deviations in which 95 % of noise lie
SCALES: Final = {"m": (1e3, "mm"), "m/s": (1e3, "mm/s"), "N m": (1e3, "N mm")}
CHANNEL_NAMES: Final = {
    "indentation": "depth",
    "normal_force": "normal force",
    "time_in_contact": "time in contact",
}
# of the model in question, and of those before it: as on the page
COLOURS: Final = {0: "C0", -1: "C1", -2: "C2"}
STYLES: Final = {0: "-", -1: "--", -2: ":"}
Curves = Mapping[str, Any]
"""What :func:`curves` gives, of all channels or of one."""
VARIABLES: Final = ("indentation", "normal_force", "speed", "time_in_contact", "time", "temperature")


def drawn_time(recording: Recording) -> Floats:
    """Return the time [s] with every pause between trials as short as :data:`PAUSE_DRAWN_S`."""
    steps = np.diff(recording.t, prepend=recording.t[0])
    steps[np.flatnonzero(np.diff(recording.episode) != 0) + 1] = PAUSE_DRAWN_S
    drawn: Floats = np.cumsum(steps)
    return drawn


def scaled(unit: str) -> tuple[float, str]:
    """Return factor and name of the unit in which a quantity of ``unit`` is drawn."""
    return SCALES.get(unit, (1.0, unit.replace("degC", "°C")))


def draw_channels(title: str, models: Mapping[str, Curves], folder: Path) -> list[Path]:
    """Draw :func:`channel_figure` of every channel into ``folder``; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for channel in next(iter(models.values())):
        files.append(folder / f"{channel}.png")
        save_figure(channel_figure(title, models, channel), files[-1])
    return files


def channel_figure(title: str, models: Mapping[str, Curves], channel: str) -> "Figure":
    """Return what the page shows of a channel: over time, what is left, and over what may matter.

    ``models``: :func:`curves` by the names of one model, or of several of which the last is the one in
    question; of the others the residual is not drawn over the variables.
    """
    every = {name: record[channel] for name, record in models.items() if channel in record}
    last = list(every.values())[-1]
    variables = list(last["variables"])
    rows = [variables[i : i + IN_A_ROW] for i in range(0, len(variables), IN_A_ROW)]
    mosaic: Any = [["over time"] * IN_A_ROW, ["left"] * IN_A_ROW]
    mosaic += [[*row, *["."] * (IN_A_ROW - len(row))] for row in rows]
    figure = empty_figure((10.0, 5.2 + 2.2 * len(rows)))
    axes = figure.subplot_mosaic(mosaic, height_ratios=[3.0, 2.0, *[2.0] * len(rows)])
    figure.suptitle(title)
    _draw_over_time(axes["over time"], channel, every)
    _draw_left(axes["left"], every)
    for variable in variables:
        _draw_over(axes[variable], variable, last["variables"][variable])
    return figure


def _draw_over_time(axis: "Axes", channel: str, every: Curves) -> None:
    last = list(every.values())[-1]
    (scale, unit), columns = scaled(last["unit"]), last["columns"]
    noise = SIGMA * (last["noise"] or 0.0)
    t, low, high = (_parted(columns, name) for name in ("time", "measured_low", "measured_high"))
    band = "measured, with 95 % of the noise"
    axis.fill_between(t, scale * (low - noise), scale * (high + noise), color="0.75", lw=0.5, label=band)
    for i, (name, record) in enumerate(every.items(), 1 - len(every)):
        model = (_parted(record["columns"], "model_low") + _parted(record["columns"], "model_high")) / 2.0
        axis.plot(
            _parted(record["columns"], "time"), scale * model, color=COLOURS[i], ls=STYLES[i], label=name
        )
    axis.set(xlabel=TIME_LABEL, ylabel=f"{channel.replace('_', ' ')} [{unit}]")
    axis.margins(x=0.0)
    axis.legend(fontsize=8)


def _draw_left(axis: "Axes", every: Curves) -> None:
    for i, (name, record) in enumerate(every.items(), 1 - len(every)):
        t, low, high = (_parted(record["columns"], key) for key in ("time", "z_low", "z_high"))
        axis.fill_between(t, low, high, color=COLOURS[i], lw=0.5, alpha=0.6, label=name)
    axis.axhspan(-SIGMA, SIGMA, color="0.5", alpha=0.25, label="95 % of the noise")
    axis.set(xlabel=TIME_LABEL, ylabel="residual [noise std]")
    axis.margins(x=0.0)
    axis.legend(fontsize=8)


def _draw_over(axis: "Axes", variable: str, record: Curves) -> None:
    """Draw rms and mean of the residual in bins of a variable."""
    scale, unit = scaled(record["unit"])
    middles = [scale * (one["low"] + one["high"]) / 2.0 for one in record["bins"]]
    axis.axhline(1.0, color="0.6", ls=":", lw=1)
    axis.plot(
        middles,
        [one["rms"] for one in record["bins"]],
        "o-",
        ms=3,
        color=COLOURS[0],
        label="rms (1 is noise)",
    )
    axis.plot(middles, [one["mean"] for one in record["bins"]], "--", color=COLOURS[-1], label="mean")
    axis.set(xlabel=f"{CHANNEL_NAMES.get(variable, variable)} [{unit}]", ylabel="residual [noise std]")
    axis.set_ylim(bottom=min(axis.get_ylim()[0], 0.0), top=max(axis.get_ylim()[1], 1.5))
    axis.legend(fontsize=7)


def _parted(columns: Mapping[str, list[float]], name: str) -> Floats:
    """Return a curve with NaN where nothing was measured, so that no line is drawn there."""
    parts = [[*columns[name][run], math.nan] for run in runs(columns["time"])]
    return np.array([value for part in parts for value in part])


def measured_values(problem: Problem, residuals: Residuals) -> Floats:
    """Return the measurements in the rows of ``residuals``; of loads at slip the sizes."""
    columns = problem.measured.columns
    if residuals.channel == "tangential_force":
        none = np.zeros(columns["t"].size)
        size: Floats = np.hypot(*(columns.get(f"tangential_force_{i}", none)[residuals.rows] for i in "xy"))
        return size
    seen: Floats = columns[residuals.channel][residuals.rows]
    return seen if residuals.channel == "normal_force" else np.abs(seen)


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
