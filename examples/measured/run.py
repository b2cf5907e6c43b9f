"""What the grasp force node says of measured recordings, and where it is wrong.

``python examples/measured/run.py [FOLDER]`` prints the tables of docs/measured.md and draws its pictures into
FOLDER (default: out). The recordings are not part of the project: VEGRIP_DATA says where they are.
"""

import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

from cases import CASES, DATA, DEEP, read, run
from drifting_zero import drifting_zero
from lever import lever
from overview import overview
from relaxation_times import relaxation_times
from unknown_radius import unknown_radius


def main() -> int:
    """Print the tables, draw the pictures."""
    if not DATA.is_dir():
        print(f"skipped: there are no measured recordings in {DATA}; set VEGRIP_DATA")
        return 0
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
    out.mkdir(parents=True, exist_ok=True)
    results = {}
    for case in CASES:
        material = case.name.partition(",")[0] + ("-deep" if case is DEEP else "")
        results[case] = run(case, read(case), out / f"measured-{material}.png")
    print(overview(results), end="\n\n")
    print(relaxation_times(out / "measured-relaxation-times.png"), end="\n\n")
    print(drifting_zero(out / "measured-drifting-zero.png"), end="\n\n")
    print(unknown_radius(), end="\n\n")
    print(lever())
    return 0


if __name__ == "__main__":
    sys.exit(main())
