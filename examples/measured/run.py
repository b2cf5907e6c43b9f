"""What the grasp force node says of measured recordings, and where it is wrong.

``python examples/measured/run.py [FOLDER [PAGE]]`` prints tables of what the node makes of measured material,
draws pictures into FOLDER (default: out); in PAGE it puts the tables in place of those that are there. The
recordings are not part of the project: VEGRIP_DATA says where they are.
"""

import re
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
    tables = {
        "overview": overview(results),
        "relaxation times": relaxation_times(out / "measured-relaxation-times.png"),
        "drifting zero": drifting_zero(out / "measured-drifting-zero.png"),
        "unknown radius": unknown_radius(),
        "lever": lever(),
        "known sphere": known_sphere(results[GEL]),
    }
    print("\n\n".join(tables.values()))
    for page in map(Path, sys.argv[2:]):
        page.write_text(filled(page.read_text(encoding="utf-8"), tables), encoding="utf-8")
    return 0


def filled(text: str, tables: dict[str, str]) -> str:
    """Put each table that the page has between its marks, ``<!-- table NAME -->`` and ``<!-- end -->``."""
    for name, table in tables.items():
        marks = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        text, count = marks.subn(lambda found, table=table: f"{found[1]}{table}\n{found[2]}", text)
        if count > 1:
            raise SystemExit(f"the page has {count} places for the table {name!r}; it must have one or none")
    return text


if __name__ == "__main__":
    sys.exit(main())
