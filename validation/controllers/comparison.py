"""Controllers on the same hands, objects and disturbances.

Usage: ``python -m validation.controllers.comparison --seeds 50``.

Simulated time, one process per core; the figures are the same on every machine up to rounding. How the knobs
were tuned is in ``docs/grip-quality.md``; ``--sweep`` prints the trade-off of every controller on the tuning
seeds.
"""

import argparse
import math
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from vegrip.trials.candidates import BOUND, INFORMED, KNOBS, NAMES
from vegrip.trials.closed_loop import GRASPS, WORLDS, Course, Result, Scenario, result_of, run_scenario

TRIAL_DURATION_S = 20.0  # [s]
TUNING_SEED = 1000  # the first seed of the sweep; the comparison counts from 0
SWEEP = {
    "vegrip": (0.05, 0.1, 0.15, 0.2, 0.3),
    "constant": (2.0, 3.0, 4.0, 6.0, 8.0, 11.0),
    "cone": (0.5, 1.0, 1.5, 2.0, 5.0, 8.0, 11.0),
    "elastic": (0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6),
}


@dataclass(frozen=True, slots=True)
class Trial:
    """One run: which controller, with which knob, through which scenario."""

    name: str
    seed: int
    duration: float
    knob: float
    grasp: str = "hand"
    world: str = "old"


def run_course(trial: Trial) -> Course:
    """Run one trial."""
    scenario = Scenario(trial.seed, trial.duration, trial.grasp, trial.world)
    return run_scenario(scenario, trial.name, trial.knob)


def run_trial(trial: Trial) -> Result:
    """Run one trial and sum it up."""
    return result_of(run_course(trial))


def run_all(
    trials: Sequence[Trial], workers: int | None = None, progress: Callable[[int], object] | None = None
) -> dict[Trial, Result]:
    """Run all trials on ``workers`` processes; ``progress`` is told how many are done."""
    results: dict[Trial, Result] = {}
    with ProcessPoolExecutor(workers or os.cpu_count()) as pool:
        for trial, figure in zip(trials, pool.map(run_trial, trials), strict=True):
            results[trial] = figure
            if progress is not None:
                progress(len(results))
    return results


def summary(results: Iterable[Result]) -> dict[str, float]:
    """Sum up the trials of one controller."""
    held = list(results)
    forces = [r.mean_grip_force for r in held if not math.isnan(r.mean_grip_force)]
    return {
        "trials": len(held),
        "slips": sum(r.slips for r in held),
        "drops": sum(r.dropped for r in held),
        "slip_free": sum(r.slips == 0 and not r.dropped for r in held),
        "mean_grip_force": float(np.mean(forces)) if forces else math.nan,
        "peak_grip_force": max((r.peak_grip_force for r in held), default=math.nan),
        "min_margin": min((r.min_margin for r in held), default=math.nan),
    }


def table(results: dict[Trial, Result], title: str) -> Table:
    """Return one row per controller and knob."""
    out = Table(title=title)
    for header in ("controller", "knob", "slips", "drops", "trials without slip", "mean grip force [N]",
                   "peak [N]", "least margin"):  # fmt: skip
        out.add_column(header.replace("[", r"\["), justify="left" if header == "controller" else "right")
    for name, knob in dict.fromkeys((trial.name, trial.knob) for trial in results):
        s = summary(r for trial, r in results.items() if (trial.name, trial.knob) == (name, knob))
        out.add_row(
            name, f"{knob:g}", f"{s['slips']:.0f}", f"{s['drops']:.0f}",
            f"{s['slip_free']:.0f} of {s['trials']:.0f}", f"{s['mean_grip_force']:.2f}",
            f"{s['peak_grip_force']:.1f}", f"{s['min_margin']:.2f}",
        )  # fmt: skip
    return out


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the comparison, or the sweep, and print the table."""
    parser = argparse.ArgumentParser(prog="python -m validation.controllers.comparison", description=__doc__)
    parser.add_argument("--seeds", type=int, default=20, help="number of scenarios (default 20)")
    parser.add_argument("--duration", type=float, default=TRIAL_DURATION_S, help="of each, in s (default 20)")
    parser.add_argument("--sweep", action="store_true", help="the trade-off curves, on the tuning seeds")
    parser.add_argument("--workers", type=int, default=None, help="processes (default: one per core)")
    parser.add_argument("--grasp", choices=tuple(GRASPS), default="hand")
    parser.add_argument("--world", choices=WORLDS, default="old", help="of the friction (default old)")
    parser.add_argument("--told", action="store_true", help="controllers that know each object's friction")
    parser.add_argument("--only", nargs="+", choices=NAMES, default=NAMES, help="these controllers alone")
    given = parser.parse_args(arguments)
    first = TUNING_SEED if given.sweep else 0
    tuned = INFORMED if given.told else {n: knob for n, knob in KNOBS[given.grasp].items() if n != BOUND}
    knobs = SWEEP if given.sweep else {name: (knob,) for name, knob in tuned.items()}
    trials = [
        Trial(name, seed, given.duration, knob, given.grasp, given.world)
        for name, settings in knobs.items()
        if name in given.only
        for knob in settings
        for seed in range(first, first + given.seeds)
    ]
    console = Console()
    with console.status("simulating") as status:
        results = run_all(
            trials, given.workers, lambda done: status.update(f"simulated {done} of {len(trials)}")
        )
    console.print(
        table(results, f"{given.grasp}: {given.seeds} scenarios of {given.duration:g} s, the same for all")
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
