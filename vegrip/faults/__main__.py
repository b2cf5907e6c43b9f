"""``python -m vegrip.faults``: run the table, print it for the documents, or soak."""

import argparse
import sys
from collections.abc import Sequence

from rich.console import Console

from vegrip.faults.page import markdown
from vegrip.faults.run import run
from vegrip.faults.soak import soak
from vegrip.faults.table import CASES

MOST_OBJECTS, MOST_MEMORY = 3000, 20_000_000  # more than after the warm-up; what grows with time exceeds them


def main(arguments: Sequence[str] | None = None) -> int:
    """Return 0 when everything is as it must be, else 1."""
    parser = argparse.ArgumentParser(prog="python -m vegrip.faults", description=__doc__)
    parser.add_argument("--table", action="store_true", help="print the table of docs/faults.md and end")
    parser.add_argument("--soak", type=float, metavar="S", help="hold for S simulated seconds under faults")
    parser.add_argument("--only", default="", help="run the cases whose name contains this")
    given = parser.parse_args(arguments)
    console = Console(highlight=False, soft_wrap=True)
    if given.table:
        console.print(markdown(), markup=False)
        return 0
    if given.soak:
        return _soak(console, given.soak)
    return _run(console, given.only)


def _run(console: Console, only: str) -> int:
    failed = 0
    for case in CASES:
        if only not in case.name:
            continue
        outcome = run(case)
        complaints = outcome.complaints()
        failed += bool(complaints)
        seen = "not seen" if outcome.detected_after is None else f"seen after {outcome.detected_after:.2f} s"
        told = f"{seen}, grip {outcome.least:.2f} to {outcome.most:.2f} N"
        console.print(f"{'FAILED' if complaints else 'ok':7}{case.name}: {told}", markup=False)
        for complaint in complaints:
            console.print(f"       {complaint}", markup=False)
    return min(failed, 1)


def _soak(console: Console, duration: float) -> int:
    done = soak(duration, progress=lambda time: console.print(f"{time:8.0f} s", end="\r"))
    console.print(done, markup=False)
    grown = done.objects > MOST_OBJECTS or done.memory > MOST_MEMORY
    return int(done.dropped or done.slips > 0 or done.lost > 0 or grown)


if __name__ == "__main__":
    sys.exit(main())
