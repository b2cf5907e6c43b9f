"""How the command line shows a recording."""

from pathlib import Path
from typing import Any

import numpy as np
from rich.text import Text

from vegrip.cli._terminal import figures, print_sentences, printable, printer
from vegrip.identification.recording import Recording
from vegrip.identification.recording.channels import RECORDED, noise_name
from vegrip.identification.sensors import LOAD_REMEDY, lacking

OUT_OF_SIGHT = (
    "without a contact stiffness and memory of the material show; contact radius and friction do not"
)
OF_A_STEP = f"{OUT_OF_SIGHT}, nor in a step the exponent of the stiffness"


def describe(recording: Recording) -> dict[str, Any]:
    """Return what ``--json`` says of a recording; what is not known is null."""
    return {
        "name": recording.name,
        "finger": recording.fingertip.name,
        "radius": _number(recording.fingertip.radius),
        "rows": len(recording),
        "duration": recording.duration,
        "episodes": len(np.unique(recording.episode)),
        "columns": {
            name: {
                "unit": RECORDED[name].unit,
                "min": _number(np.fmin.reduce(values)),
                "max": _number(np.fmax.reduce(values)),
                "noise": recording.sensors.get(noise_name(name)),
            }
            for name, values in recording.columns.items()
        },
        "lacking": [OF_A_STEP if recording.is_step else OUT_OF_SIGHT]
        if recording.is_material
        else lacking(recording.columns, LOAD_REMEDY),
        "report": recording.report.as_dict(),
    }


def print_recording(recording: Recording, folder: Path) -> None:
    """Print the columns with their ranges, and everything that was found while reading."""
    console = printer()
    about = describe(recording)
    radius = f"{about['radius']:g} m" if about["radius"] is not None else "unknown"
    size = f"{about['rows']} rows, {about['duration']:.6g} s, {about['episodes']} episode(s)"
    of = "without a contact" if recording.is_material else f"{about['finger']}, radius {radius}"
    console.print(Text(printable(str(folder)), style="bold") + Text(printable(f": {size}, {of}"), "not bold"))
    table = figures("column", "unit", "min", "max", "noise std", left=("column", "unit"))
    for name, column in about["columns"].items():
        values = (column["min"], column["max"], column["noise"])
        table.add_row(name, column["unit"], *("-" if v is None else f"{v:.5g}" for v in values))
    console.print(table)
    console.print(recording.report.summary())
    print_sentences(about["lacking"])


def _number(value: float) -> float | None:
    return None if np.isnan(value) else float(value)
