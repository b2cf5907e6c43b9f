"""A comparison as curves to draw: measured and modelled over time, residuals by regime and variable.

Long recordings are thinned to columns that keep the smallest and the greatest value, so no peak is lost.
"""

from typing import Any, Final

import numpy as np

from vegrip.identification.compare.comparison import Comparison, residuals_of
from vegrip.identification.compare.features import PHASES, Features
from vegrip.identification.compare.plot import drawn_time, measured_values
from vegrip.identification.compare.where import MIN_REGIME_ROWS, Residuals
from vegrip.identification.compare.words import SPOKEN_UNITS
from vegrip.types import Floats

COLUMNS: Final = 420
BINS: Final = 12
VARIABLES: Final = ("indentation", "normal_force", "speed", "time_in_contact", "time", "temperature")


def curves(comparison: Comparison) -> dict[str, Any]:
    """Return, by channel, ``columns`` over time, ``phases`` and ``variables`` with the residual in each.

    Residuals are standardised: in units of the noise, measured less modelled.
    """
    time = drawn_time(comparison.problem.measured.recording)
    features = comparison.features
    noise = {name: one.noise for name, one in comparison.channels.items()}
    found = {}
    for residuals in residuals_of(comparison.problem, comparison.u):
        measured = measured_values(comparison, residuals)
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
    """Return the smallest, the greatest and the mean value of each column of time."""
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
