"""Judge the grip by a slip channel that is dead or lies: one line per case.

Usage: ``python tests/law/run.py --fault dead --mu 0.6 --fingers 2 --drive 12 --from 0 --seed 1``,
``python tests/law/run.py --random 100 --seed 1 --jobs 2``.
"""

import argparse
import itertools
import logging
import math
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np

tests = ModuleType("tests")  # not what another distribution may have installed by this name
tests.__path__ = [str(Path(__file__).parents[1])]
sys.modules["tests"] = tests

from tests.law.channels import FAULTS
from tests.law.grasp import Case, Outcome, draw, run
from tests.law.plant import Make
from tests.law.verdict import breaches, excused


def line(case: Case, told: Outcome) -> str:
    """Return a case and what came of it."""
    make = case.make
    end = f"dropped {told.dropped:5.1f} s" if told.dropped < math.inf else "held           "
    return (
        f"{case.fault:16s} mu {make.mu:4.2f} n {make.fingers} drive {make.drive:4.1f} from {case.start:4.1f}"
        f" gain {case.gain:4.2f}{'~' if case.gain_drifts and case.gain != 1.0 else ' '} seed {case.seed:4d} |"
        f" {end} slid {1e3 * told.slid:6.2f} mm finger {1e3 * told.finger:6.2f} mm"
        f" over least {told.over_least:5.2f} after {told.after_fault:5.2f} peak {told.peak:4.1f} N"
        f" contradicted {told.contradicted:5.2f} named {told.named:5.2f} explained {told.explained:5.2f}"
        f" mu {told.friction:4.2f} {told.said[:110]!r}"
    )


def command(case: Case) -> str:
    """Return the command that runs a case again."""
    given = {
        "fault": case.fault, "mu": repr(case.make.mu), "fingers": case.make.fingers,
        "load": repr(case.make.load),
        "drive": repr(case.make.drive), "stiffness": repr(case.make.stiffness), "kinetic": case.make.kinetic,
        "plant": case.make.seed, "from": repr(case.start), "seed": case.seed, "rises": case.rises,
        "rise-at": repr(case.rise_at),
    }  # fmt: skip
    words = [f"--{name} {value}" for name, value in given.items()]
    if case.which:
        words.append("--which " + " ".join(map(str, case.which)))
    if case.gain != 1.0:
        words.append(f"--gain {case.gain!r}" + (" --gain-drifts" if case.gain_drifts else ""))
    if case.gain_start >= 0.0:
        words.append(f"--gain-from {case.gain_start!r}")
    words += ["--exact"] * case.exact + [f"--falls {case.falls!r}"] * (case.falls > 0.0)
    words += [f"--falls-at {case.falls_at}"] * (case.falls_at >= 0)
    words += ["--no-learning"] * (not case.learns)
    return "python tests/law/run.py " + " ".join(words)


def judged(case: Case) -> tuple[Case, Outcome, list[str], list[str], str]:
    """Run a case and judge it."""
    told = run(case)
    raw = list(breaches(case, told))
    left, bare = excused(case, told, raw)
    return case, told, raw, left, bare


def parsed(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--fault", nargs="+", choices=tuple(FAULTS), default=None, metavar="FAULT", help=", ".join(FAULTS))
    add("--mu", type=float, nargs="+", default=[0.6])
    add("--fingers", type=int, nargs="+", default=[2])
    add("--drive", type=float, nargs="+", default=[12.0], help="[Hz]")
    add("--from", dest="start", type=float, nargs="+", default=[0.0], help="[s] when the fault begins")
    add("--seed", type=int, nargs="+", default=[1])
    add("--plant", type=int, default=1, help="seed of the scatter of the fingers")
    add("--load", type=float, default=1.0, help="[N]")
    add("--stiffness", type=float, default=2000.0, help="[N/m]")
    add("--kinetic", type=float, default=1.0)
    add("--which", type=int, nargs="+", default=(), help="fingers with the fault, 0 = thumb; all")
    add("--gain", type=float, default=1.0, help="of the tangential force")
    add("--gain-drifts", action="store_true", help="it gets there in 50 s")
    add("--gain-from", type=float, default=-1.0)
    add("--falls", type=float, default=0.0, help="[s] when friction halves within 0.3 s")
    add("--falls-at", type=int, default=-1, help="of this finger alone")
    add("--rises", type=int, default=8)
    add("--rise-at", type=float, default=0.0)
    add("--exact", action="store_true", help="a sound channel says exactly 0 where nothing slides")
    add("--no-learning", action="store_true", help="the grip without probing")
    add("--duration", type=float, default=60.0)
    add("--rate", type=int, default=200)
    add("--objects", action="store_true", help="embedded objects instead of the compiled step")
    add("--healthy", action="store_true", help="a sound channel: what trust costs")
    add("--random", type=int, default=0, help="so many cases at random")
    add("--all", action="store_true", help="print all of them, not the breaches alone")
    add("--jobs", type=int, default=1)
    return parser.parse_args(arguments)


def cases_of(given: argparse.Namespace) -> list[Case]:
    faults = ["none"] if given.healthy else given.fault or ["" if given.random else "none"]
    if given.random:
        rng = np.random.default_rng([given.seed[0], 99])
        drawn = [draw(rng, faults[i % len(faults)]) for i in range(given.random)]
        if given.healthy:
            drawn = [replace(case, gain=1.0, start=0.0) for case in drawn]
        how = {"duration": given.duration, "rate": given.rate, "learns": not given.no_learning}
        return [replace(case, **how) for case in drawn]
    cases = []
    for fault, mu, n, drive, start, seed in itertools.product(
        faults, given.mu, given.fingers, given.drive, given.start, given.seed
    ):
        make = Make(n, mu, given.load, drive, 60.0, given.stiffness, 0.05, given.kinetic, given.plant)
        case = Case(make, fault, start, tuple(given.which), given.gain, given.gain_drifts, given.gain_from)
        cases.append(
            replace(case, falls=given.falls, falls_at=given.falls_at, rises=given.rises,
                    rise_at=given.rise_at, exact=given.exact, learns=not given.no_learning,
                    duration=given.duration, rate=given.rate, seed=seed)
        )  # fmt: skip
    return cases


def main(arguments: Sequence[str] | None = None) -> int:
    given = parsed(arguments)
    logging.disable(logging.WARNING)
    cases = cases_of(given)
    began = time.perf_counter()
    if not given.random:
        with ProcessPoolExecutor(given.jobs) as pool:
            for case, told in zip(cases, pool.map(_run, cases, [given.objects] * len(cases)), strict=True):
                print(line(case, told), "|", "; ".join(breaches(case, told)), flush=True)
        return 0
    bad = counted = forgiven = 0
    healthy = []
    with ProcessPoolExecutor(given.jobs) as pool:
        for case, told, raw, left, bare in pool.map(judged, cases):
            counted += 1
            bad += bool(left)
            forgiven += bool(raw) and not left
            healthy.append((told.over_least, told.slid, told.finger))
            if left or given.all:
                print(
                    line(case, told),
                    "|",
                    "; ".join(left) or "kept",
                    "|",
                    bare,
                    "\n   ",
                    command(case),
                    flush=True,
                )
    ratios = np.array([ratio for ratio, _, _ in healthy])
    print(
        f"{counted} cases: {bad} break the law, {forgiven} only as the grip without a channel does;"
        f" over least: median {np.nanmedian(ratios):.2f}, mean {np.nanmean(ratios):.2f};"
        f" slid by > 0.1 mm: {sum(slid > 1e-4 for _, slid, _ in healthy)};"
        f" {(time.perf_counter() - began) / counted:.2f} s a case"
    )
    return 1 if bad else 0


def _run(case: Case, objects: bool) -> Outcome:
    return run(case, objects=objects)


if __name__ == "__main__":
    sys.exit(main())
