"""How much of the fall of the force after its peak the motion alone explains, to a model without memory."""

from pathlib import Path

import numpy as np

from vegrip.identification.compare import compare
from vegrip.identification.fit import noise_of
from vegrip.identification.fit.problem import AT
from vegrip.identification.recording import read_recording
from vegrip.model import read_model


def fall(folder: Path, file: str, tolerance: float) -> tuple[float, float, float]:
    """Return the mean fall from peak to end: measured, by the model [shares], and of the displacement [m]."""
    recording = read_recording(folder)
    found = compare(recording, read_model(file), noise=noise_of(recording).tolerant(tolerance))
    said = found.problem.table(found.u)[:, AT["normal_force"]]
    seen, depth = recording.columns["normal_force"], recording.columns["displacement"]
    falls = []
    for number in np.unique(recording.episode):
        rows = np.flatnonzero(recording.episode == number)
        last = rows[-5:]
        falls.append([
            1.0 - np.mean(seen[last]) / np.max(seen[rows]),
            1.0 - np.mean(said[last]) / np.max(said[rows]),
            np.max(depth[rows]) - np.mean(depth[last]),
        ])  # fmt: skip
    measured, modelled, moved = np.mean(falls, axis=0)
    return float(measured), float(modelled), float(moved)
