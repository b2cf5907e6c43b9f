"""Judge the grip by channels that are dead or lie: one line per case.

Usage: ``python tests/law/run.py --fault dead --mu 0.6 --fingers 2 --drive 12 --from 0 --seed 1``,
``python tests/law/run.py --fault dead-flag --also tangential-drifts``,
``python tests/law/run.py --random 100 --seed 1 --jobs 2``, with two faults each ``--pairs 100``, with every
pair of faults ``--all-pairs --mu 0.15 0.25 0.4 0.65 1.1``, with one friction each ``--in-turn``.
"""

import argparse
import itertools
import logging
import math
import re
import sys
import time
from collections import Counter
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
from tests.law.grasp import WORLDS, Case, Occurrence, Outcome, draw, run
from tests.law.pairs import LEAST_MU, MOST_MU, REAL, all_pairs, draw_pair
from tests.law.plant import Make
from tests.law.sensors import SENSOR_FAULTS
from tests.law.verdict import breaches, excused


def line(case: Case, told: Outcome) -> str:
    """Return a case and what came of it."""
    make = case.make
    end = f"dropped {told.dropped:5.1f} s" if told.dropped < math.inf else "held           "
    faults = " + ".join(f"{one.fault} from {one.start:.1f}" for one in case.faults)
    return (
        f"{faults:26s} mu {make.mu:4.2f} g {make.exponent:4.2f} n {make.fingers} drive {make.drive:4.1f}"
        f" gain {case.tangential_gain:4.2f} * {case.gain:4.2f}"
        f"{'~' if case.gain_drifts and case.gain != 1.0 else ' '} seed {case.seed:4d} |"
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
    words += [f"--exponent {case.make.exponent!r}"] * (case.make.exponent != 0.0)
    words += [f"--tangential-gain {case.tangential_gain!r}"] * (case.tangential_gain != 1.0)
    if case.which:
        words.append("--which " + " ".join(map(str, case.which)))
    for one in case.also:
        words.append(f"--also {one.fault} --also-from {one.start!r}")
        words += ["--also-which " + " ".join(map(str, one.which))] * bool(one.which)
    if case.gain != 1.0:
        words.append(f"--gain {case.gain!r}" + (" --gain-drifts" if case.gain_drifts else ""))
    if case.gain_start >= 0.0:
        words.append(f"--gain-from {case.gain_start!r}")
    words += ["--exact"] * case.exact + [f"--falls {case.falls!r}"] * (case.falls > 0.0)
    words += [f"--falls-at {case.falls_at}"] * (case.falls_at >= 0)
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
    names = (*FAULTS, *SENSOR_FAULTS)
    add("--fault", nargs="+", choices=names, default=None, metavar="FAULT", help=", ".join(names))
    add("--also", choices=names, default=None, metavar="FAULT", help="one more fault")
    add("--also-from", type=float, default=0.0, help="[s] when it begins")
    add("--also-which", type=int, nargs="+", default=(), help="fingers with it; all")
    add("--mu", type=float, nargs="+", default=[0.6], help="at 5 N")
    add("--exponent", type=float, default=0.0, help="g of mu (N / 5 N)^-g")
    add("--tangential-gain", type=float, default=1.0, help="with which tangential forces are measured")
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
    add("--duration", type=float, default=60.0)
    add("--rate", type=int, default=200)
    add("--objects", action="store_true", help="embedded objects instead of the compiled step")
    add("--healthy", action="store_true", help="a sound channel: what trust costs")
    add("--random", type=int, default=0, help="so many cases at random")
    add("--pairs", type=int, default=0, help="so many cases at random with two faults")
    add("--all-pairs", action="store_true", help="every pair of faults with each --mu")
    add(
        "--world",
        choices=tuple(WORLDS),
        default="real",
        help="of --random: old has no load-dependent friction",
    )
    add("--in-turn", action="store_true", help="of --all-pairs: each pair with one --mu")
    add("--least-mu", type=float, default=LEAST_MU, help="of --pairs")
    add("--all", action="store_true", help="print all of them, not the breaches alone")
    add("--jobs", type=int, default=1)
    return parser.parse_args(arguments)


def cases_of(given: argparse.Namespace) -> list[Case]:
    how = {"duration": given.duration, "rate": given.rate}
    if given.random or given.pairs or given.all_pairs:
        return [replace(case, **how) for case in drawn(given)]
    cases = []
    for fault, mu, n, drive, start, seed in itertools.product(
        given.fault or ["none"], given.mu, given.fingers, given.drive, given.start, given.seed
    ):
        make = Make(
            n, mu, given.load, drive, 60.0, given.stiffness, 0.05, given.kinetic, given.plant, given.exponent
        )
        case = Case(make, fault, start, tuple(given.which), given.gain, given.gain_drifts, given.gain_from)
        cases.append(
            replace(case, falls=given.falls, falls_at=given.falls_at, rises=given.rises,
                    rise_at=given.rise_at, exact=given.exact, seed=seed, also=also(given),
                    tangential_gain=given.tangential_gain, **how)
        )  # fmt: skip
    return cases


def also(given: argparse.Namespace) -> tuple[Occurrence, ...]:
    if given.also is None:
        return ()
    return (Occurrence(given.also, given.also_from, tuple(given.also_which)),)


def drawn(given: argparse.Namespace) -> list[Case]:
    """Draw the cases that are judged together."""
    seed = given.seed[0]
    if given.all_pairs:
        return all_pairs(given.mu, seed, in_turn=given.in_turn)
    rng = np.random.default_rng([seed, 99])
    if given.pairs:
        world = replace(REAL, mu=(given.least_mu, MOST_MU))
        return [draw_pair(rng, world=world) for _ in range(given.pairs)]
    faults = ["none"] if given.healthy else given.fault or [""]
    cases = [draw(rng, faults[i % len(faults)], WORLDS[given.world]) for i in range(given.random)]
    return [replace(case, gain=1.0, start=0.0) for case in cases] if given.healthy else cases


def main(arguments: Sequence[str] | None = None) -> int:
    given = parsed(arguments)
    logging.disable(logging.WARNING)
    cases = cases_of(given)
    began = time.perf_counter()
    if not (given.random or given.pairs or given.all_pairs):
        with ProcessPoolExecutor(given.jobs) as pool:
            for case, told in zip(cases, pool.map(_run, cases, [given.objects] * len(cases)), strict=True):
                print(line(case, told), "|", "; ".join(breaches(case, told)), flush=True)
        return 0
    bad = counted = forgiven = 0
    outcomes, kinds = [], Counter[str]()
    with ProcessPoolExecutor(given.jobs) as pool:
        for case, told, raw, left, bare in pool.map(judged, cases):
            counted += 1
            bad += bool(left)
            forgiven += bool(raw) and not left
            kinds.update(re.match("[A-Z ]*[A-Z]", one)[0].lower() for one in raw)
            outcomes.append((told.over_least, told.slid, told.finger))
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
    ratios = np.array([ratio for ratio, _, _ in outcomes])
    print(
        f"{counted} cases: {bad} break the law, {forgiven} only as the grip without a channel does;"
        f" in all {', '.join(f'{kind} {number}' for kind, number in sorted(kinds.items()))};"
        f" over least: median {np.nanmedian(ratios):.2f}, mean {np.nanmean(ratios):.2f};"
        f" slid by > 0.1 mm: {sum(slid > 1e-4 for _, slid, _ in outcomes)};"
        f" {(time.perf_counter() - began) / counted:.2f} s a case"
    )
    return 1 if bad else 0


def _run(case: Case, objects: bool) -> Outcome:
    return run(case, objects=objects)


if __name__ == "__main__":
    sys.exit(main())
