"""Fronts of controllers: slips against force over least possible force, over each controller's knob.

Every controller meets the same seeds. A :class:`Surroundings` changes what all of them meet: the drives, the
friction of every surface, the slip channel.
"""

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

from vegrip.trials.candidates import BOUND, KNOBS, parameters, told_of_slip
from vegrip.trials.closed_loop import SAMPLING_S, Course, run_grip
from vegrip.trials.grip_quality import GripRecord, figures_of, record_of
from vegrip.trials.scenario import Scenario
from vegrip.trials.slip_channels import wrong_slip
from vegrip.virtual import HandSettings, VirtualHand
from vegrip.virtual.settings import SensorSettings

SWEEPS = {
    "hand": {
        "vegrip": (0.0, 0.05, 0.1, 0.15, 0.2, 0.3),
        "learning": (0.05, 0.1, 0.15, 0.2, 0.3),
        "known": (0.05, 0.1, 0.15, 0.2),
        "constant": (2.0, 3.0, 4.0, 6.0),
        "cone": (0.5, 1.0, 1.5, 2.0),
        "elastic": (0.3, 0.35, 0.4, 0.45, 0.5, 0.6),
    },
    "pinch": {
        "vegrip": (0.0, 0.05, 0.1, 0.15, 0.2, 0.3),
        "learning": (0.05, 0.1, 0.15, 0.2, 0.3),
        "known": (0.05, 0.1, 0.15, 0.2),
        "constant": (4.0, 6.0, 8.0, 11.0),
        "cone": (3.0, 5.0, 8.0, 11.0),
        "elastic": (0.3, 0.35, 0.4, 0.5, 0.6),
    },
}

USUAL_SENSOR = SensorSettings()


@dataclass(frozen=True)
class Surroundings:
    """What differs from the usual hand, for all controllers."""

    drive_bandwidth: float = math.nan  # [Hz]; NaN = as it is; the rate limit goes in proportion
    friction_scale: float = 1.0  # [-] of every surface
    slip_threshold: float = USUAL_SENSOR.slip_threshold  # [m/s] from which slip is felt
    slip_delay: float = USUAL_SENSOR.slip_delay  # [s] by which it is late
    slip_channel: str = "sound"  # of SLIP_CHANNELS: what is wrong with it

    def applied(self, hand: HandSettings) -> HandSettings:
        """Return ``hand`` in these surroundings."""
        drives = hand.actuator
        if not math.isnan(self.drive_bandwidth):
            rate = drives.force_rate * self.drive_bandwidth / drives.bandwidth
            drives = replace(drives, bandwidth=self.drive_bandwidth, force_rate=rate)
        sensor = replace(
            hand.sensor,
            slip_sensor=self.slip_channel != "absent",
            slip_threshold=self.slip_threshold,
            slip_delay=self.slip_delay,
        )
        tip = replace(hand.tip, friction=hand.tip.friction * self.friction_scale)
        return replace(hand, actuator=drives, sensor=sensor, tip=tip)


@dataclass(frozen=True)
class QualityTrial:
    """One run: which controller, with which knob, through which scenario, in which surroundings."""

    name: str
    seed: int
    duration: float  # [s]
    knob: float
    grasp: str
    surroundings: Surroundings = Surroundings()
    measures_lag: bool = False  # of the drives, instead of being told


def run_quality_trial(trial: QualityTrial) -> Course:
    """Run one trial."""
    scenario = Scenario(trial.seed, trial.duration, trial.grasp)
    hand = trial.surroundings.applied(scenario.settings)
    settings = told_of_slip(parameters(trial.name, trial.knob, hand.tip.friction), hand.sensor)
    grip = replace(settings.grip, measure_lag=trial.measures_lag and settings.grip.drive_lag > 0.0)
    settings = replace(settings, grip=grip)
    return run_grip(
        VirtualHand(hand, trial.seed, scenario.events), settings, trial.duration,
        knows=trial.name == BOUND, spoil=wrong_slip(trial.surroundings.slip_channel, trial.seed),
    )  # fmt: skip


def record_trial(trial: QualityTrial) -> GripRecord:
    """Run one trial and keep what its figures need."""
    scenario = Scenario(trial.seed, trial.duration, trial.grasp)
    return record_of(run_quality_trial(trial), scenario.events, scenario.settings.actuator.close_time)


def trials_of(
    knobs: Mapping[str, Sequence[float]],
    seeds: Iterable[int],
    duration: float,
    grasp: str,
    surroundings: Surroundings,
    *,
    measures_lag: bool = False,
) -> list[QualityTrial]:
    """Return every controller with every knob on every seed; those that lead the load may measure the lag."""
    return [
        QualityTrial(name, seed, duration, knob, grasp, surroundings, measures_lag)
        for name, values in knobs.items()
        for knob in values
        for seed in seeds
    ]


def run_fronts(
    trials: Sequence[QualityTrial],
    workers: int | None = None,
    progress: Callable[[int], object] | None = None,
) -> dict[str, dict[float, dict[str, Any]]]:
    """Run all trials on ``workers`` processes; return name -> knob -> figures.

    ``progress`` is told how many are done.
    """
    records: dict[tuple[str, float], list[GripRecord]] = {}
    count = workers or os.cpu_count() or 1
    if count == 1:
        found: Iterable[GripRecord] = map(record_trial, trials)
        _collect(trials, found, records, progress)
    else:
        record_trial(replace(trials[0], duration=0.1))  # compiles once, for all processes
        with ProcessPoolExecutor(count) as pool:
            _collect(trials, pool.map(record_trial, trials, chunksize=4), records, progress)
    fronts: dict[str, dict[float, dict[str, Any]]] = {}
    for (name, knob), some in records.items():
        fronts.setdefault(name, {})[knob] = figures_of(some, SAMPLING_S)
    return fronts


def told_of(fronts: Mapping[str, Mapping[float, dict[str, Any]]], grasp: str) -> dict[str, dict[str, Any]]:
    """Return each controller's figures at its operating point, and its ``front`` over the knob."""
    told = {}
    for name, front in fronts.items():
        knob = KNOBS[grasp][name]
        points = [{"knob": value, **figures} for value, figures in sorted(front.items())]
        told[name] = {"knob": knob, **front[knob], "front": points}
    return told


def _collect(
    trials: Sequence[QualityTrial],
    found: Iterable[GripRecord],
    records: dict[tuple[str, float], list[GripRecord]],
    progress: Callable[[int], object] | None,
) -> None:
    for done, (trial, record) in enumerate(zip(trials, found, strict=True), 1):
        records.setdefault((trial.name, trial.knob), []).append(record)
        if progress is not None:
            progress(done)


def knobs_of(grasp: str, names: Sequence[str], *, sweep: bool) -> dict[str, tuple[float, ...]]:
    """Return the knobs of each controller: its operating point, or that and those of its front."""
    tuned: dict[str, tuple[float, ...]] = {name: (KNOBS[grasp][name],) for name in names}
    if not sweep:
        return tuned
    return {name: tuple(sorted({*SWEEPS[grasp].get(name, ()), *tuned[name]})) for name in names}
