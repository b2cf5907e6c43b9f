"""Fronts of the rules over materials drawn at random: holds that slip against force over least possible.

The force over least is the mean over the holds of the true force over the least possible one, both averaged
from the lift to the end. The first hold of a pair of pads is that of an unknown material; by the second one a
rule has met it.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from validation.controllers.position_hold.trial import HoldResult, HoldTrial, run_holds
from vegrip.trials.fronts import clopper_pearson

KNOBS: dict[str, tuple[float, ...]] = {
    "elastic": (0.4, 0.6, 0.8, 1.0, 1.2, 1.4),
    "elastic, again": (0.06, 0.12, 0.25, 0.5),
    "last ratio": (0.0, 0.1, 0.2, 0.3),
    "forecast": (0.3, 0.5, 0.7, 0.85, 0.95),
    "forecast, again": (0.5, 0.7, 0.85, 0.95),
}
"""By rule: the constant on top, or the probability to hold [-]."""
HOLDS = ("first hold", "second hold")

Fronts = dict[str, dict[str, list[dict[str, Any]]]]
"""Hold -> rule -> figures over the knob."""


def trials_of(materials: Iterable[int], seeds: int) -> list[HoldTrial]:
    """Return every rule with every knob on every pair of pads."""
    return [
        HoldTrial(rule, knob, material, seed)
        for material in materials
        for seed in range(seeds)
        for rule, knobs in KNOBS.items()
        for knob in knobs
    ]


def run_study(
    trials: Sequence[HoldTrial], jobs: int = 1, progress: Callable[[int], object] | None = None
) -> Fronts:
    """Run all trials on ``jobs`` processes; ``progress`` is told how many are done."""
    results: dict[tuple[str, float], list[tuple[HoldResult, ...]]] = {}

    def collect(found: Iterable[tuple[HoldResult, ...]]) -> None:
        for done, (trial, result) in enumerate(zip(trials, found, strict=True), 1):
            results.setdefault((trial.rule, trial.knob), []).append(result)
            if progress is not None:
                progress(done)

    if jobs == 1:
        collect(map(run_holds, trials))
    else:
        run_holds(trials[0])  # compiles once, for all processes
        with ProcessPoolExecutor(min(jobs, os.cpu_count() or 1)) as pool:
            collect(pool.map(run_holds, trials, chunksize=8))
    return fronts_of(results)


def fronts_of(results: Mapping[tuple[str, float], Sequence[tuple[HoldResult, ...]]]) -> Fronts:
    """Return the figures of every rule and knob, apart for the first and the second holds."""
    fronts: Fronts = {hold: {} for hold in HOLDS}
    for (rule, knob), pairs in results.items():
        for i, hold in enumerate(HOLDS):
            point = {"knob": knob, **figures_of([pair[i] for pair in pairs])}
            fronts[hold].setdefault(rule, []).append(point)
    return fronts


def figures_of(holds: Sequence[HoldResult]) -> dict[str, Any]:
    """Sum up the holds of one rule with one knob."""
    slipped = sum(hold.slipped for hold in holds)
    ratios = np.array([hold.force / hold.least for hold in holds])
    return {
        "holds": len(holds),
        "slipped": slipped,
        "slip_probability_bounds": clopper_pearson(slipped, len(holds)),
        "force_over_least": float(ratios.mean()),
        "largest_force_over_least": float(ratios.max()),
        "peak_over_least": float(np.mean([hold.closing / hold.least for hold in holds])),
        "tightenings": float(np.mean([hold.tightenings for hold in holds])),
        "known_over_least": float(np.mean([hold.oracle / hold.least for hold in holds])),
    }
