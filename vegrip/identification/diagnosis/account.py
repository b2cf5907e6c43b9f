"""An account of a diagnosis, as JSON and as pictures: data, models, errors, what remains unknown."""

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np

from vegrip.identification.compare.comparison import Comparison, residuals_of
from vegrip.identification.compare.plot import TIME_LABEL, curves, drawn_time, measured_values
from vegrip.identification.compare.where import SPOKEN_UNITS, Residuals, features_of
from vegrip.identification.diagnosis.diagnosis import Diagnosis
from vegrip.identification.diagnosis.discrepancy import find_discrepancy
from vegrip.identification.diagnosis.error_ladder import build_ladder
from vegrip.identification.fit.problem import Problem
from vegrip.identification.recording import Recording
from vegrip.plotting import new_figure, save_figure
from vegrip.types import Floats

DATA = ("recording.csv", "recording.csv.gz")
HASH_BLOCK_BYTES = 1 << 20  # [bytes]
PACKAGES = ("vegrip", "numpy", "scipy", "numba")
AXES: Final = {
    # variable: name of the feature, factor, label
    "displacement": ("indentation", 1e3, "displacement [mm]"),
    "normal_force": ("normal_force", 1.0, "normal force of the model [N]"),
    "speed": ("speed", 1e3, "speed [mm/s]"),
    "time": ("time", 1.0, "time since the start [s]"),
    "temperature": ("temperature", 1.0, "temperature [degC]"),
}
USUAL_VARIABLE: Final = "displacement"


def account(
    found: Diagnosis, folder: Path, commands: list[str], experiment: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Return everything a report of ``found`` needs, as JSON has it.

    Args:
        found: the diagnosis.
        folder: of the recording.
        commands: that make this again.
        experiment: what to measure next, as :meth:`Diagnosis.as_dict` takes it.

    """
    first, last = found.search.first, found.search.last
    before, after = (Comparison(one.problem, one.optimum.u, fitted=True) for one in (first, last))
    result = found.result.as_dict()
    return {
        "ladder": [asdict(rung) for rung in build_ladder(found)],
        "verdict": found.verdict,
        "noise_floor": 1.0,
        "data": described(found.start.problem.measured.recording, folder),
        "diagnosis": found.as_dict(experiment),
        "before": before.as_dict() | {"curves": curves(before)},
        "after": after.as_dict() | {"curves": curves(after)},
        "parameters": result["parameters"],
        "warnings": result["warnings"],
        "commands": commands,
        "versions": versions(),
    }


def described(recording: Recording, folder: Path) -> dict[str, Any]:
    """Return what was measured, and a checksum that tells this recording from others."""
    columns = recording.columns
    return {
        "name": recording.name,
        "folder": str(folder),
        "sha256": _checksum(folder),
        "rows": len(recording),
        "duration": float(recording.t[-1] - recording.t[0]),
        "episodes": int(np.unique(recording.episode).size),
        "tip_radius": recording.fingertip.radius,
        "channels": {
            name: [float(np.nanmin(values)), float(np.nanmax(values))]
            for name, values in columns.items()
            if name not in ("t", "episode") and np.isfinite(values).any()
        },
    }


def versions() -> dict[str, str]:
    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}


def _checksum(folder: Path) -> str:
    for name in DATA:
        if (folder / name).is_file():
            digest = hashlib.sha256()
            with (folder / name).open("rb") as file:
                while block := file.read(HASH_BLOCK_BYTES):
                    digest.update(block)
            return digest.hexdigest()
    return ""


@dataclass(frozen=True, eq=False)
class _Side:
    name: str
    colour: str
    error: float
    residuals: Residuals


def draw_diagnosis(found: Diagnosis, folder: Path, start: str) -> list[Path]:
    """Draw one picture per channel into ``folder``; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    problem, u = found.search.first.problem, found.search.first.optimum.u
    values = features_of(problem, u).values
    telling = find_discrepancy(found.search.first)
    variable = telling.variable if telling is not None and telling.variable in AXES else USUAL_VARIABLE
    feature, factor, label = AXES[variable]
    files = []
    for sides in _channels(found, start):
        channel = sides[0].residuals.channel
        figure, axes = new_figure(3, size=(9, 9))
        title = f"{problem.measured.recording.name}: {channel.replace('_', ' ')}, {found.verdict}"
        figure.suptitle(f"{title} {', '.join(found.named)}".rstrip())
        t = drawn_time(problem.measured.recording)
        _draw_measured(axes[0], problem, sides, t)
        _draw_left(axes[1], sides, t, TIME_LABEL)
        _draw_left(axes[2], sides, factor * values[feature], label)
        axes[1].legend(markerscale=6, fontsize=8)
        files.append(folder / f"{channel}.png")
        save_figure(figure, files[-1])
    return files


def _channels(found: Diagnosis, start: str) -> list[list[_Side]]:
    first, last = found.search.first, found.search.last
    added = [one.candidate.name for one in found.search.accepted]
    models = [(start, "C3", first)]
    if added:
        models.append((f"{start} + {' + '.join(added)}", "C0", last))
    sides = [
        [_Side(name, colour, fitted.error, one) for one in residuals_of(fitted.problem, fitted.optimum.u)]
        for name, colour, fitted in models
    ]
    by_channel = [{side.residuals.channel: side for side in model} for model in sides]
    return [[model[channel] for model in by_channel if channel in model] for channel in by_channel[0]]


def _draw_measured(axis: Any, problem: Problem, sides: list[_Side], t: Floats) -> None:
    residuals = sides[0].residuals
    axis.plot(t[residuals.rows], measured_values(problem, residuals), "k.", ms=2, label="measured")
    for side in sides:
        model = measured_values(problem, side.residuals) - side.residuals.raw
        label = f"{side.name}: {side.error:.2f} x noise"
        axis.plot(t[side.residuals.rows], model, ".", color=side.colour, ms=1.2, label=label)
    axis.legend(markerscale=6, fontsize=8)
    axis.set_xlabel(TIME_LABEL)
    axis.set_ylabel(f"{residuals.channel.replace('_', ' ')} [{SPOKEN_UNITS[residuals.channel]}]")


def _draw_left(axis: Any, sides: list[_Side], x: Floats, label: str) -> None:
    for side in sides:
        one, unit = side.residuals, SPOKEN_UNITS[side.residuals.channel]
        name = f"{side.name}: rms {float(np.sqrt(np.mean(one.raw**2))):.2g} {unit}"
        axis.plot(x[one.rows], one.raw, ".", color=side.colour, ms=1.5, label=name)
    axis.axhline(0.0, color="0.5", lw=0.8)
    axis.set_xlabel(label)
    axis.set_ylabel(f"measured - model [{SPOKEN_UNITS[sides[0].residuals.channel]}]")
