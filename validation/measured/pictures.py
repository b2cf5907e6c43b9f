"""Pictures: an episode that was fitted and one that was held out, measured and by both models."""

from pathlib import Path
from typing import Literal

import matplotlib as mpl
import numpy as np

from vegrip.identification.compare import compare
from vegrip.identification.fit import noise_of
from vegrip.identification.fit.problem import AT
from vegrip.identification.recording import read_recording
from vegrip.model import read_model

mpl.use("Agg")

from matplotlib import pyplot as plt

from validation.measured.cases import Case

POINTS = 1500


def draw(case: Case, folder: Path, picture: Path) -> None:
    """Draw force over time, and what each model leaves of it."""
    names = ("train", "heldout") if case.heldout else ("train",)
    figure, axes = plt.subplots(
        2, len(names), figsize=(9, 4.6), sharex="col", layout="constrained", squeeze=False,
        height_ratios=(3, 2),
    )  # fmt: skip
    unit, factor = case.unit
    for column, (name, shown) in enumerate(zip(names, case.shown, strict=False)):
        recording = read_recording(folder / name)
        tolerance = float(case.options[case.options.index("--tolerance") + 1])
        zeros: Literal["recording", "episode"] = (
            "episode" if "--zeros-each-episode" in case.options else "recording"
        )
        rows = np.flatnonzero(recording.episode == np.unique(recording.episode)[shown])
        rows = rows[:: max(rows.size // POINTS, 1)]
        t = recording.t[rows] - recording.t[rows[0]]
        force = recording.columns["normal_force"][rows]
        top, bottom = axes[0, column], axes[1, column]
        top.plot(t, factor * force, "k.", ms=2, label="measured")
        for file, label, colour in (
            ("start", "the paper's model", "C1"),
            ("refined", "with what was added", "C0"),
        ):
            found = compare(
                recording,
                read_model(folder / f"{file}.toml"),
                noise=noise_of(recording).tolerant(tolerance),
                zeros=zeros,
            )
            said = found.problem.table(found.u)[rows, AT["normal_force"]]
            top.plot(t, factor * said, color=colour, lw=1, label=label)
            bottom.plot(t, factor * (force - said), color=colour, lw=1)
        top.set_title("fitted" if name == "train" else "held out", fontsize=10)
        top.set_ylabel(f"normal force [{unit}]")
        bottom.set(xlabel="time in the episode [s]", ylabel=f"measured - model [{unit}]")
        for axis in (top, bottom):
            axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize="small")
    figure.suptitle(case.title, fontsize=11)
    figure.savefig(picture, dpi=70, pil_kwargs={"optimize": True})
    plt.close(figure)
