"""Grippers that close on force and then hold position: constants on top against a memory of the contact.

Usage: ``python -m validation.controllers.position_hold --materials 24 -o fronts.png``.

Materials, loads and noise are drawn from seeds, the same for every rule.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from validation.controllers.position_hold.study import Fronts, run_study, trials_of


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study, print its fronts, draw them."""
    parser = argparse.ArgumentParser(
        prog="python -m validation.controllers.position_hold", description=__doc__
    )
    parser.add_argument("--materials", type=int, default=24, help="pairs of pads (default 24)")
    parser.add_argument("--first", type=int, default=0, help="number of the first material (default 0)")
    parser.add_argument("--seeds", type=int, default=2, help="loads of each material (default 2)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("-o", "--output", type=Path, default=None, help="picture of the fronts")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args(arguments)
    if given.materials < 1 or given.seeds < 1 or given.jobs < 1 or given.first < 0:
        parser.error("--materials, --seeds and --jobs are at least 1, --first is at least 0")
    console = Console(stderr=True)
    trials = trials_of(range(given.first, given.first + given.materials), given.seeds)
    with console.status("holding") as status:
        fronts = run_study(trials, given.jobs, lambda done: status.update(f"{done} of {len(trials)} trials"))
    if given.output is not None:
        from validation.controllers.position_hold.plot import draw_fronts  # noqa: PLC0415 (an extra)

        draw_fronts(fronts, given.output)
        console.print(f"picture: {given.output}", markup=False, soft_wrap=True)
    if given.json:
        sys.stdout.write(json.dumps(fronts) + "\n")
    else:
        for hold in fronts:
            Console().print(table(fronts, hold))
    return 0


def table(fronts: Fronts, hold: str) -> Table:
    """Return one row per rule and knob."""
    out = Table(title=hold)
    for header in ("rule", "knob", "slipped", "95 %", "force over least", "largest", "peak over least",
                   "tightened again"):  # fmt: skip
        out.add_column(header, justify="left" if header == "rule" else "right")
    for rule, points in fronts[hold].items():
        for point in points:
            low, high = point["slip_probability_bounds"]
            out.add_row(
                rule, f"{point['knob']:g}", f"{point['slipped']} of {point['holds']}",
                f"{low:.2f} to {high:.2f}", f"{point['force_over_least']:.2f}",
                f"{point['largest_force_over_least']:.2f}", f"{point['peak_over_least']:.2f}",
                f"{point['tightenings']:.1f}",
            )  # fmt: skip
    known = next(iter(fronts[hold].values()))[0]["known_over_least"]
    out.caption = f"one closing with everything known: {known:.2f}"
    return out


if __name__ == "__main__":
    sys.exit(main())
