"""The measured-data loop: fit, see where, add what pays, and see whether recordings held out agree.

``python -m validation.measured.worked [DATA [FOLDER]]`` fits, refines and diagnoses the
measured recordings in DATA (default: VEGRIP_DATA; they are no part of the project), prints tables and draws
the pictures into FOLDER (default: out). ``--only NAME`` runs one example.
"""

import argparse
import contextlib
import io
import json
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

from validation.measured.backing_off import fall
from validation.measured.cases import CASES, MAPS, Case, data_folder, tables
from validation.measured.pictures import draw
from validation.measured.places import own_stiffness
from vegrip.cli import main as vegrip


def told(*arguments: str) -> dict[str, Any]:
    """Run a command with ``--json`` and return what it prints."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()) as err:
        code = vegrip([*arguments, "--json"])
    if code != 0:
        raise SystemExit(f"vegrip {' '.join(arguments)} ended with {code}: {err.getvalue().strip()}")
    found: dict[str, Any] = json.loads(out.getvalue())
    return found


def run(case: Case, data: Path, out: Path) -> str:
    """Go round the loop; return the table."""
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        radius = ("--radius", case.radius) if case.radius else ()
        sets = ("train", "heldout") if case.heldout else ("train",)
        for which, name in enumerate(sets):
            rows = tables(case, data, here / f"{name}-rows", which)
            chart = str(MAPS / f"{case.column_map}.toml")
            told("import", *map(str, rows), "-o", str(here / name), "--map-file", chart, *radius)
        start, refined = str(here / "start.toml"), str(here / "refined.toml")
        fit = told("fit", str(here / "train"), "-o", start, *case.options)
        train = str(here / "train")
        ladder = told("refine", train, "-o", refined, "--most", str(case.most), *case.options)
        notes = []
        if case.backs_off:
            tolerance = float(case.options[case.options.index("--tolerance") + 1])
            seen, said, moved = fall(here / "train", start, tolerance)
            notes.append(f"| fall after the peak: measured {seen:.1%} | {said:.1%} | |")
            notes.append(f"| meanwhile the finger opens by {1e6 * moved:.0f} um | | |")
        doubts = told("diagnose", train, *case.options)["doubts"] if case.add else []
        if case.add and len(ladder["ladder"]) == 1:
            told("add", case.add, train, "-o", refined, "--force", *case.options)
        errors = [
            [told("compare", str(here / name), "--model", model, *case.options) for model in (start, refined)]
            for name in sets
        ]
        draw(case, here, out / f"worked-{case.name}.png")
        places = own_stiffness(here / "heldout", (start, refined), case.options) if case.scaled else None
    notes += [f"| it says | {one} | |" for one in doubts]
    return "\n".join([table(case, fit, ladder, errors, places), *notes])


def table(
    case: Case,
    fit: dict[str, Any],
    ladder: dict[str, Any],
    errors: list[list[dict[str, Any]]],
    places: list[float] | None,
) -> str:
    """Return what came of a case, as Markdown."""
    unit, factor = case.unit
    added = [rung["effect"] for rung in ladder["ladder"] if rung["effect"]]
    lines = ["| | the paper's model | with what was added |", "|---|---|---|"]
    for name, pair in zip(("fitted", "held out"), errors, strict=False):
        force = [one["channels"]["normal_force"]["rmse"] * factor for one in pair]
        ratio = [one["error"] for one in pair]
        lines.append(f"| {name}: error over what was asked | {ratio[0]:.2f} | {ratio[1]:.2f} |")
        lines.append(f"| {name}: force, rms | {force[0]:.3g} {unit} | {force[1]:.3g} {unit} |")
    if places is not None:
        lines.append(f"| held out, each place with its own stiffness | {places[0]:.2f} | {places[1]:.2f} |")
    by_hand = f"nothing; by hand: {case.add}" if case.add else "nothing"
    lines.append(f"| added, in this order | | {', '.join(added) or by_hand} |")
    lines.append(f"| verdict | | {ladder['verdict']} |")
    values = fit["parameters"]
    base = ", ".join(f"{s} {values[s]['value']:.3g}" for s in ("K", "p", "c1", "nu1"))
    lines.append(f"| parameters of the paper's model | {base} | |")
    where = errors[0][0]["where"]
    lines.append(f"| where it failed most | {where[0]['note'] if where else 'nowhere'} | |")
    return "\n".join(lines)


def filled(text: str, found: dict[str, str]) -> str:
    """Put each table that the page has between its marks, ``<!-- table NAME -->`` and ``<!-- end -->``."""
    for name, markdown in found.items():
        marks = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", re.DOTALL)

        def put(mark: re.Match[str], table: str = markdown) -> str:
            return f"{mark[1]}{table}\n{mark[2]}"

        text, count = marks.subn(put, text)
        if count > 1:
            raise SystemExit(f"the page has {count} places for the table {name!r}; it must have one or none")
    return text


def main() -> int:
    """Run the examples, print the tables, draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("data", nargs="?", default="")
    parser.add_argument("folder", nargs="?", default="out", type=Path)
    parser.add_argument("--only", default="")
    given = parser.parse_args()
    data = data_folder(given.data)
    if not data.is_dir():
        raise SystemExit(f"there are no measured recordings in {data}; set VEGRIP_DATA")
    given.folder.mkdir(parents=True, exist_ok=True)
    for case in CASES:
        if given.only in ("", case.name):
            print(f"\n{case.title}\n\n{run(case, data, given.folder)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
