"""What a drifting zero of the force does to the estimates: the runs on one oocyte."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from cases import DATA, MAPS, OOCYTE, read, run
from matplotlib import pyplot as plt

from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.import_csv import import_csv

RUNS = (1, 4, 8, 12, 13)


def drifting_zero(picture: Path) -> str:
    """Run the node with the force zeroed before contact, and as the sensor gives it."""
    chart = read_column_map(MAPS / "afm_oocyte.toml")
    as_sensed = {"normal_force": replace(chart.channels["normal_force"], zero="none")}
    lines = [
        "| run | force in air | K, force zeroed | K, force as sensed | refused |",
        "|---|---|---|---|---|",
    ]
    zeros, stiffness = [], []
    for number in RUNS:
        case = replace(OOCYTE, file=f"afm-hold/oocyte_relax_{number:04d}.csv")
        zeroed = read(case)
        force = import_csv(DATA / case.file, replace(chart, channels=as_sensed)).columns["normal_force"]
        # the indentation still counts from first touch: only the force is as the sensor gives it
        sensed = replace(zeroed, columns={**zeroed.columns, "normal_force": force})
        results = [run(case, recording) for recording in (zeroed, sensed)]
        zeros.append(float(force[zeroed.t < 0.95].mean()))
        stiffness.append([result.learned["K"][0] for result in results])
        refused = [result.told()["rejected"] for result in results]
        k = [f"{1e9 * value:.0f} nN" for value in stiffness[-1]]
        lines.append(
            f"| {number} | {1e9 * zeros[-1]:+.0f} nN | {k[0]} | {k[1]} | {refused[0]}, {refused[1]} |"
        )
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(8, 4.4), layout="constrained")
    top.plot(RUNS, 1e9 * np.array(zeros), "ko-", ms=4)
    top.set(
        ylabel="force in air [nN]", title="Oocyte: the zero of the force drifts, and the stiffness seems to"
    )
    for values, label, style in zip(
        np.transpose(stiffness), ("zeroed", "as sensed"), ("o-", "s--"), strict=True
    ):
        bottom.plot(RUNS, 1e9 * values, style, ms=4, label=f"force {label}")
    bottom.set(xlabel="run", ylabel="K learned [nN at 5 µm]")
    bottom.set_ylim(bottom=0.0)
    bottom.legend(fontsize="small")
    for axis in (top, bottom):
        axis.grid(alpha=0.3)
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    return "\n".join(lines)
