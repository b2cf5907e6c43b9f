"""What the grasp force node says of measured recordings, and where it is wrong.

``python examples/measured/run.py [FOLDER]`` prints tables of what the node makes of measured material, and
draws pictures into FOLDER (default: out). The recordings are not part of the project: VEGRIP_DATA says where
they are.
"""

import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

from cases import CASES, DATA, DEEP, GEL, OOCYTE, SKIN, picture, read, run
from drifting_zero import drifting_zero
from known_sphere import known_sphere
from lever import lever
from overview import overview
from relaxation_times import relaxation_times
from unknown_radius import unknown_radius

SKIPPED = 77  # exit code of a run without its data


def main() -> int:
    """Print the tables, draw the pictures."""
    if not DATA.is_dir():
        print(f"skipped: there are no measured recordings in {DATA}; set VEGRIP_DATA")
        return SKIPPED
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
    out.mkdir(parents=True, exist_ok=True)
    for case, name in ((DEEP, "silicone-deep"), (SKIN, "skin"), (OOCYTE, "oocyte"), (GEL, "gel")):
        picture(case, out / f"measured-{name}.png")
    results = {case: run(case, read(case)) for case in CASES}
    tables = (
        overview(results),
        relaxation_times(out / "measured-relaxation-times.png"),
        drifting_zero(out / "measured-drifting-zero.png"),
        unknown_radius(),
        lever(),
        known_sphere(results[GEL]),
    )
    print("\n\n".join(tables))
    return 0


if __name__ == "__main__":
    sys.exit(main())
