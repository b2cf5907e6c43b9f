"""Pictures of a comparison: measured and predicted, what is left over time, phase and depth."""

from pathlib import Path
from typing import Any

import numpy as np

from vegrip.compare.comparison import Comparison, residuals_of
from vegrip.compare.features import PHASES
from vegrip.errors import UsageError


def draw(comparison: Comparison, folder: Path) -> list[Path]:
    """Draw one picture per channel into ``folder``; return the files.

    Raises:
        UsageError: matplotlib is not installed.

    """
    try:
        import matplotlib as mpl  # noqa: PLC0415
    except ImportError as error:
        raise UsageError("pictures need matplotlib; pip install 'vegrip[plot]'") from error
    mpl.use("Agg")
    from matplotlib import pyplot as plt  # noqa: PLC0415

    folder.mkdir(parents=True, exist_ok=True)
    features = comparison.features
    files = []
    for residuals in residuals_of(comparison.problem, comparison.u):
        figure, axes = plt.subplots(3, 1, figsize=(9, 8), constrained_layout=True)
        rows = np.arange(residuals.rows.size)  # pauses between episodes left out
        axes[0].plot(rows, residuals.z, ".", ms=1.5)
        _labels(axes[0], "row", "residual / std")
        axes[0].set_title(f"{comparison.problem.measured.recording.name}: {residuals.channel}")
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
        figure.savefig(files[-1], dpi=110)
        plt.close(figure)
    return files


def _labels(axis: Any, x: str, y: str) -> None:
    axis.axhspan(-1.96, 1.96, color="0.9")
    axis.set_xlabel(x)
    axis.set_ylabel(y)
