"""``python -m validation.faults``: run the table, print it for the documents, or soak."""

import argparse
import logging
import sys
from collections.abc import Sequence

from rich.console import Console

from validation.faults.page import markdown, rogue_programs_table
from validation.faults.rogue_programs import Act, Outcome, perform
from validation.faults.run import run
from validation.faults.soak import soak
from validation.faults.table import CASES
from validation.faults.wall_clock_soak import wall_soak

MOST_OBJECTS, MOST_MEMORY = 3000, 20_000_000  # more than after the warm-up; what grows with time exceeds them


def main(arguments: Sequence[str] | None = None) -> int:
    """Return 0 when everything is as it must be, else 1."""
    parser = argparse.ArgumentParser(prog="python -m validation.faults", description=__doc__)
    parser.add_argument("--table", action="store_true", help="print the tables of docs/faults.md and end")
    parser.add_argument("--soak", type=float, metavar="S", help="hold for S simulated seconds under faults")
    parser.add_argument(
        "--wall",
        type=float,
        metavar="S",
        help="the same for S seconds of the wall clock, with real processes",
    )
    parser.add_argument(
        "--strangers", action="store_true", help="what programs that misbehave do to a node on ZeroMQ (1 min)"
    )
    parser.add_argument("--only", default="", help="run the cases whose name contains this")
    given = parser.parse_args(arguments)
    console = Console(highlight=False, soft_wrap=True)
    if given.table:
        console.print(f"{markdown()}\n\n{rogue_programs_table()}", markup=False)
        return 0
    if given.soak:
        return _soak(console, given.soak)
    if given.wall:
        return _wall(console, given.wall)
    if given.strangers:
        return _strangers(console, given.only)
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


def _wall(console: Console, duration: float) -> int:
    done = wall_soak(duration, progress=lambda line: console.print(line, markup=False))
    console.print(
        f"{sum(done.accidents.values())} accidents in {done.duration:.0f} s: {dict(done.accidents)}\n"
        f"commands again after {done.slowest_recovery:.1f} s at most, "
        f"least measured grip {done.least_grip:.2f} N",
        markup=False,
    )
    for pid, used in done.footprints.items():
        console.print(
            f"{used.name:16} {pid:7} {len(used.time):5} s  {used.memory[-1] / 1e6:6.1f} MB, "
            f"{used.growth:+.2f} MB/min; {used.descriptors[-1]} descriptors, {used.threads[-1]} threads",
            markup=False,
        )
    for complaint in done.complaints:
        console.print(f"FAILED {complaint}", markup=False)
    return min(len(done.complaints), 1)


def _strangers(console: Console, only: str) -> int:
    def tell(act: Act, outcome: Outcome) -> None:
        back = "never" if outcome.back_after is None else f"after {outcome.back_after:.2f} s"
        forces = (
            f"least command {outcome.before:.2f} N before, {outcome.least:.2f} to {outcome.most:.2f} N after"
        )
        counted = f"{act.counted_as} {outcome.counted}"
        console.print(
            f"{'FAILED' if outcome.complaints else 'ok':7}{act.name}: {counted}; well {back}; {forces}",
            markup=False,
        )
        for complaint in outcome.complaints:
            console.print(f"       {complaint}", markup=False)

    return int(not perform(tell, only))


if __name__ == "__main__":
    logging.getLogger("vegrip").setLevel(logging.ERROR)  # lost input is what is played here
    sys.exit(main())
