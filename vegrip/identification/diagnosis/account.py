"""An account of a diagnosis, as JSON and as pictures: data, models, errors, what remains unknown."""

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from vegrip.identification.compare.comparison import Comparison
from vegrip.identification.compare.plot import curves, draw_channels
from vegrip.identification.diagnosis.diagnosis import Diagnosis
from vegrip.identification.diagnosis.error_ladder import build_ladder
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel

DATA = ("recording.csv", "recording.csv.gz")
HASH_BLOCK_BYTES = 1 << 20  # [bytes]
PACKAGES = ("vegrip", "numpy", "scipy", "numba")


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
        "effects": effects_of(last.problem.model),
        "diagnosis": found.as_dict(experiment),
        "before": before.as_dict() | {"curves": curves(before)},
        "after": after.as_dict() | {"curves": curves(after)},
        "parameters": result["parameters"],
        "warnings": result["warnings"],
        "commands": commands,
        "versions": versions(),
    }


def described(recording: Recording, folder: Path) -> dict[str, Any]:
    """Return what was measured, and a checksum that distinguishes this recording from others."""
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


def effects_of(model: ContactModel) -> list[dict[str, Any]]:
    """Return what a model consists of, in the order in which it acts: names, laws, keys of their sources."""
    return [{"name": one.name, "summary": one.summary, "cites": list(one.cites)} for one in model.effects]


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


def models_of(found: Diagnosis, start: str = "start model") -> dict[str, dict[str, Any]]:
    """Return the curves of the model at the start and, where effects were accepted, of that with them."""
    first, last = found.search.first, found.search.last
    models = {f"{start}: {first.error:.2f} x noise": first}
    if added := [one.candidate.name for one in found.search.accepted]:
        models[f"with {', '.join(added)}: {last.error:.2f} x noise"] = last
    return {name: curves(Comparison(one.problem, one.optimum.u, fitted=True)) for name, one in models.items()}


def title_of(found: Diagnosis) -> str:
    names = f" {', '.join(found.named)}" if found.named else ""
    return f"{found.start.recording.name}: {found.verdict}{names}"


def draw_diagnosis(found: Diagnosis, folder: Path, start: str) -> list[Path]:
    """Draw one picture per channel into ``folder``; return the files."""
    return draw_channels(title_of(found), models_of(found, start), folder)
