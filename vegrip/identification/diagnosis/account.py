"""An account of a diagnosis that can be kept and shown later: data, models, errors, what remains unknown."""

import hashlib
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from vegrip.identification.compare.comparison import Comparison
from vegrip.identification.compare.curves import curves
from vegrip.identification.diagnosis.diagnosis import Diagnosis
from vegrip.identification.diagnosis.error_ladder import build_ladder
from vegrip.identification.recording import Recording

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
        "ladder": [rung.as_dict() for rung in build_ladder(found)],
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
    """Return the versions of what has computed this."""
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
