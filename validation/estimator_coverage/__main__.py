"""Coverage: ``python -m validation.estimator_coverage --truths 9``, or ``--slips``, ``--styles``."""

import argparse
import json
from collections.abc import Sequence

from validation.estimator_coverage import slip_table, style_table, worst
from validation.estimator_coverage.drives import STYLES
from validation.estimator_coverage.table import (
    CONFIGURATIONS,
    COVERED_QUANTITIES,
    coverage,
    fingertip,
    independent_coverage,
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line, run, print."""
    parser = argparse.ArgumentParser(prog="python -m validation.estimator_coverage", description=__doc__)
    parser.add_argument("--truths", type=int, default=100, help="random fingertips per configuration")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start-in-contact", action="store_true", help="the record begins within a contact")
    parser.add_argument("--independent", action="store_true", help="fingertips of the virtual hand")
    parser.add_argument(
        "--slips", type=int, help="instead: time to slip, over so many slips in each scenario"
    )
    parser.add_argument(
        "--branches", type=int, help="number of relaxation times, with --slips (default: all)"
    )
    parser.add_argument("--styles", type=int, help="instead: lives from outside, so many fingers per style")
    parser.add_argument("--worst", type=int, help="instead: search the worst of so many lives per style")
    parser.add_argument(
        "--json", action="store_true", help="least and largest of the table alone, in percent"
    )
    options = parser.parse_args(arguments)
    if options.styles is not None or options.worst is not None:
        print_styles(options.styles or 0, options.worst or 0, options.seed)
        return
    if options.slips is not None:
        print("time to slip, in percent of the looks (number of looks)")  # noqa: T201
        print(slip_table.header())  # noqa: T201
        for row in slip_table.table(options.slips, options.seed, options.branches):
            print(row, flush=True)  # noqa: T201
        return
    shares: list[float] = []
    if not options.json:
        print("95 % coverage in percent (number of looks)")  # noqa: T201
        print("sensors".ljust(12), *(name.rjust(13) for name in COVERED_QUANTITIES))  # noqa: T201
    for configuration in CONFIGURATIONS:
        if options.independent:
            found = independent_coverage(configuration, options.truths, options.seed)
        else:
            start = options.start_in_contact
            found = coverage(fingertip(), configuration, options.truths, options.seed, start_in_contact=start)
        shares += [100 * found[name].share for name in COVERED_QUANTITIES]
        if options.json:
            continue
        cells = (
            f"{100 * found[name].share:.1f} ({found[name].count})".rjust(13) for name in COVERED_QUANTITIES
        )
        print(configuration.ljust(12), *cells, flush=True)  # noqa: T201
    if options.json:
        print(json.dumps({"least": min(shares), "largest": max(shares)}))  # noqa: T201


def print_styles(fingers: int, tries: int, seed: int) -> None:
    """Print the table of lives from outside, and the worst life of each style."""
    if fingers > 0:
        print("95 % coverage in percent; worst error of N and indentation in standard deviations")  # noqa: T201
        print(style_table.header())  # noqa: T201
        for style in STYLES:
            print(style_table.row(style, list(style_table.results(style, fingers, seed))), flush=True)  # noqa: T201
    if tries > 0:
        for style in STYLES:
            print(worst.describe(worst.search(style, tries, seed)), flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
