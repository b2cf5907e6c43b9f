"""What the node makes of a lever that oscillates before it touches."""

from dataclasses import replace

import numpy as np
from cases import DATA, SKIN, read, run


def lever() -> str:
    """Count the samples before first touch for which the node says that there is contact."""
    lines = [
        "| recording | deepest spike in air | of the time in air, contact is reported |",
        "|---|---|---|",
    ]
    for path in sorted((DATA / "skin-force-hold").glob("*.csv")):
        case = replace(SKIN, file=f"skin-force-hold/{path.name}")
        recording = read(case)
        result = run(case, recording)
        touch = recording.t[np.flatnonzero(recording.columns["displacement"] == 0.0)[0]]
        early = result.contact["in_contact"][result.contact["t"] < touch].mean()
        spike = recording.columns["normal_force"][recording.t < touch].min()
        lines.append(f"| {path.stem} | {1e3 * spike:.0f} mN | {early:.1%} |")
    return "\n".join(lines)
