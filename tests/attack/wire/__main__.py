"""Attacks the node over its wires: ``python tests/attack/wire --cases 50`` or ``--seconds 600``.

A hand written from ``proto/`` alone sends states with faults drawn from seeds to the real codec and node, in
simulated time. What breaks a law is told with the command that repeats it.
"""

import argparse
import logging
import sys
import time
from collections import Counter

from canaries import CANARIES
from faults import BEGIN, KINDS, VALUES, Case, drawn
from laws import complaints


def main() -> int:
    """Attack, print what breaks a law and a line for each kind; return the exit code."""
    asked = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    asked.add_argument("--only", default="", help="part of the name of a fault or channel")
    asked.add_argument("--seed", type=int, default=0, help="of the first case")
    asked.add_argument("--cases", type=int, default=2 * len({**KINDS, **VALUES}))
    asked.add_argument("--seconds", type=float, default=0.0, help="go on for so long instead")
    asked.add_argument("--canaries", action="store_true", help="attack nodes that are broken on purpose")
    given = asked.parse_args()
    logging.disable()  # the node says in words what is counted here
    failures = show_canaries() if given.canaries else attack(given)
    return 1 if failures else 0


def attack(given: argparse.Namespace) -> int:
    """Run case after case; return how many break a law."""
    kinds = [kind for kind in (*KINDS, *VALUES) if given.only in kind]
    cases, failures = Counter[str](), Counter[str]()
    seed, deadline = given.seed, time.monotonic() + given.seconds
    while seed < given.seed + given.cases or time.monotonic() < deadline:
        case = drawn(seed, kinds)
        cases[case.what] += 1
        if found := complaints(case):
            failures[case.what] += 1
            only = f"--only '{given.only}' " if given.only else ""
            print(f"{case}: {'; '.join(found)}")
            print(f"  again: python tests/attack/wire {only}--seed {seed} --cases 1", flush=True)
        seed += 1
    for kind, count in cases.items():
        print(f"{'FAILED' if failures[kind] else 'ok':6} {kind}: {count} cases, {failures[kind]} break a law")
    return failures.total()


def show_canaries() -> int:
    """Attack each of the broken nodes once; return in how many a law is broken."""
    case = Case("can", "other version", BEGIN, 0.3, (0, 1), 1.0, 0.0, seed=0)
    failures = 0
    for name, make in CANARIES.items():
        found = complaints(case, make)
        failures += bool(found)
        print(f"{'FAILED' if found else 'ok':6} {name}: {'; '.join(found)}")
    return failures


if __name__ == "__main__":
    sys.exit(main())
