"""Fronts of controllers: slips against force over least possible force, over each controller's knob.

Every controller meets the same seeds. A :class:`Surroundings` changes what all of them meet: the drives, the
friction of every surface, the slip channel.
"""

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import betaincinv

from vegrip.plotting import new_figure, save_figure
from vegrip.trials.candidates import BOUND, KNOBS, parameters, with_slip_channel
from vegrip.trials.closed_loop import SAMPLING_S, SETTLED_S, Course, Scenario, run_grip
from vegrip.trials.known_contact import LeastForce, Plant, least_force
from vegrip.types import Floats
from vegrip.virtual import Disturbance, HandSettings, VirtualHand
from vegrip.virtual.disturbance import AddedMass, Push, Shake, SlowLoad, Turn, Twist, Wetting
from vegrip.virtual.settings import SensorSettings

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CLASSES = ("static", "slow", "shock", "torsion", "wet", "lift")
"""Of disturbances; where several act, the last of this order counts, the lift always."""
CLASS_OF = {
    SlowLoad: "slow", AddedMass: "slow", Turn: "slow", Push: "shock", Shake: "shock", Twist: "torsion",
    Wetting: "wet",
}  # fmt: skip
LIFT_END_S = 1.5
"""[s] until which a trial is in its lift; it begins when the stand gives way."""
NEAR_SLIP = 0.02
"""True margin below which a contact is on the verge of slipping [-]."""
QUANTILE = 0.05
CONFIDENCE = 0.95
INSIDE = 1.959964
"""Standard deviations of a Gaussian within which 95 % lie."""
BELIEVED = ("friction_error", "friction_std")

Classes = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


@dataclass(frozen=True)
class GripRecord:
    """One trial, row by row from the lift on."""

    slips: int
    dropped: bool
    largest_micro_slip: float  # [m]
    force: Floats  # (n,) [N] grip force: the normal force of the first finger
    least: Floats  # (n,) [N] least possible
    margin: Floats  # (n,) [-] least true margin of the fingers
    slipped: Floats  # (n,) slips that began in this row
    classes: Classes  # (n,) place in CLASSES
    settled: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]  # (n,) the hand carries the object by itself
    friction_error: Floats  # (n, fingers) stated less apparent ln mu, in its stds; NaN = no contact
    friction_std: Floats  # (n, fingers) of ln mu as stated
    lags: Floats = field(default_factory=lambda: np.zeros(0))  # (m,) [s] of the drives, as far as known


def least_forces(course: Course) -> Floats:
    """Return the least possible force [N] of each finger at every time of ``course``; (n, fingers)."""
    forces, contacts = np.array(course.force), np.array(course.contact).reshape(-1, 5)
    rows = zip(forces.ravel().tolist(), contacts.tolist(), strict=True)
    g = course.friction_exponent
    least = [course.least(force, f, m, mu, radius, k, g) for force, (f, m, mu, radius, k) in rows]
    return np.array(least).reshape(-1, len(course.fingers))


def least_grip_force(course: Course) -> Floats:
    """Return the least possible grip force [N] at every time of ``course``."""
    each = least_forces(course)
    larger: Floats = np.maximum(each[:, 0], each[:, 1:].sum(axis=1))
    return larger


def force_over_least(course: Course, start: float, end: float = math.inf) -> float:
    """Return the sum of the grip force over the sum of the least from ``start`` to ``end`` [s].

    NaN where it is never held.
    """
    least, force, time = least_grip_force(course), np.array(course.force), np.array(course.time)
    counted = (time >= start) & (time <= end) & np.isfinite(least)
    total = float(least[counted].sum())
    return float(force[counted, 0].sum()) / total if total > 0.0 else math.nan


def record_of(
    course: Course, events: Sequence[Disturbance], lift_start: float, gain: float = 1.0
) -> GripRecord:
    """Return the record of ``course`` from ``lift_start`` [s] on.

    Tangential forces are read times ``gain``: the friction that is stated is the apparent one, gain mu.
    """
    time = np.array(course.time)
    kept = time >= lift_start
    time = time[kept]
    stated, mu = np.array(course.stated)[kept], np.array(course.contact)[kept, :, 2]
    error, std = stated[:, :, 0] - np.log(gain * mu), stated[:, :, 1]
    return GripRecord(
        slips=course.slips,
        dropped=course.dropped,
        largest_micro_slip=course.largest_micro_slip,
        force=np.array(course.force)[kept, 0],
        least=least_grip_force(course)[kept],
        margin=np.array(course.margin)[kept].min(axis=1),
        slipped=np.diff(np.array(course.slipped, float)[kept], prepend=0.0),
        classes=classes_of(time, events),
        settled=time >= SETTLED_S,
        friction_error=np.divide(error, std, out=np.full_like(std, math.nan), where=std > 0.0),
        friction_std=std,
        lags=np.array([lag for lag in course.lags if math.isfinite(lag)]),
    )


def classes_of(time: Floats, events: Sequence[Disturbance]) -> Classes:
    """Return the class of each ``time`` [s]; (n,) places in :data:`CLASSES`."""
    found = np.zeros(len(time), np.int64)
    for event in events:
        acts = (time > event.start) & (time < event.start + event.duration)
        found[acts] = np.maximum(found[acts], CLASSES.index(CLASS_OF[type(event)]))
    found[time < LIFT_END_S] = CLASSES.index("lift")
    return found


def figures_of(records: Iterable[GripRecord], sampling: float) -> dict[str, Any]:
    """Sum up the trials of one controller at one knob; rows are ``sampling`` [s] apart.

    Force, margin, near slips and what is believed of friction count from when the hand carries the object,
    slips from the start.
    """
    trials = list(records)
    rows = {
        name: np.concatenate([getattr(trial, name) for trial in trials])
        for name in ("force", "least", "margin", "slipped", "classes", "settled", *BELIEVED)
    }
    counted = rows["settled"] & np.isfinite(rows["least"])
    lags = np.concatenate([trial.lags for trial in trials])
    slipping = sum(trial.slips > 0 or trial.dropped for trial in trials)
    return {
        "trials": len(trials),
        "slips": sum(trial.slips for trial in trials),
        "drops": sum(trial.dropped for trial in trials),
        "trials_with_slip": slipping,
        "slip_probability_bounds": clopper_pearson(slipping, len(trials)),
        "largest_micro_slip": max((trial.largest_micro_slip for trial in trials), default=math.nan),
        "drive_lag": float(np.median(lags)) if len(lags) else math.nan,
        **_held(rows, counted, sampling, len(trials)),
        **_coverage(rows, rows["settled"]),
        "by_class": {
            name: {
                "slips": int(rows["slipped"][rows["classes"] == i].sum()),
                **_held(rows, (rows["classes"] == i) & np.isfinite(rows["least"]), sampling, len(trials)),
                **_coverage(rows, rows["classes"] == i),
            }
            for i, name in enumerate(CLASSES)
        },
    }


def _held(rows: dict[str, Floats], counted: Floats, sampling: float, trials: int) -> dict[str, float]:
    force, least, margin = (rows[name][counted.astype(bool)] for name in ("force", "least", "margin"))
    if not len(force):
        return dict.fromkeys(
            ("mean_force", "force_over_least", "margin_q05", "time_below_002", "seconds"), math.nan
        )
    return {
        "mean_force": float(force.mean()),
        "force_over_least": float(force.sum() / least.sum()) if least.sum() > 0.0 else math.nan,
        "margin_q05": float(np.quantile(margin, QUANTILE)),
        "time_below_002": float((margin < NEAR_SLIP).sum() * sampling / trials),
        "seconds": float(len(force) * sampling / trials),
    }


def _coverage(rows: dict[str, Floats], counted: Floats) -> dict[str, float]:
    """Return the share of looks with the true friction inside the stated interval, and how wide that is."""
    error, std = (rows[name][counted.astype(bool)] for name in ("friction_error", "friction_std"))
    known = np.isfinite(error)
    if not known.any():
        return {"friction_inside": math.nan, "friction_std": math.nan}
    inside = np.abs(error[known]) <= INSIDE
    return {"friction_inside": float(inside.mean()), "friction_std": float(np.median(std[known]))}


def clopper_pearson(hits: int, trials: int) -> tuple[float, float]:
    """Return the exact interval of a probability at 95 % from ``hits`` of ``trials``."""
    if trials == 0:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = float(betaincinv(hits, trials - hits + 1, tail)) if hits > 0 else 0.0
    high = float(betaincinv(hits + 1, trials - hits, 1.0 - tail)) if hits < trials else 1.0
    return low, high


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
class PlantMake:
    """How a simulated hand is made, and the limit of its contacts."""

    make: Callable[[HandSettings, int, Sequence[Disturbance]], Plant] = VirtualHand
    least: LeastForce = least_force


OURS = PlantMake()


@dataclass(frozen=True)
class QualityTrial:
    """One run: which controller, with which knob, through which scenario, in which surroundings."""

    name: str
    seed: int
    duration: float  # [s]
    knob: float
    grasp: str
    surroundings: Surroundings = Surroundings()
    world: str = "old"  # one of WORLDS
    plant: PlantMake = OURS

    @property
    def scenario(self) -> Scenario:
        return Scenario(self.seed, self.duration, self.grasp, self.world)


def run_quality_trial(trial: QualityTrial) -> Course:
    scenario = trial.scenario
    hand = trial.surroundings.applied(scenario.settings)
    settings = with_slip_channel(parameters(trial.name, trial.knob, hand.tip.friction), hand.sensor)
    return run_grip(
        trial.plant.make(hand, trial.seed, scenario.events), settings, trial.duration,
        knows=trial.name == BOUND, spoil=wrong_slip(trial.surroundings.slip_channel, trial.seed),
        least=trial.plant.least,
    )  # fmt: skip


def record_trial(trial: QualityTrial) -> GripRecord:
    hand, events = trial.scenario.settings, trial.scenario.events
    return record_of(run_quality_trial(trial), events, hand.actuator.close_time, hand.sensor.tangential_gain)


def trials_of(
    knobs: Mapping[str, Sequence[float]],
    seeds: Iterable[int],
    duration: float,
    grasp: str,
    surroundings: Surroundings,
    *,
    world: str = "old",
    plant: PlantMake = OURS,
) -> list[QualityTrial]:
    """Return every controller with every knob on every seed."""
    return [
        QualityTrial(name, seed, duration, knob, grasp, surroundings, world, plant)
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

    ``progress`` is given how many are done.
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


def summaries_of(
    fronts: Mapping[str, Mapping[float, dict[str, Any]]], grasp: str
) -> dict[str, dict[str, Any]]:
    """Return each controller's figures at its operating point, and its ``front`` over the knob."""
    summaries = {}
    for name, front in fronts.items():
        knob = KNOBS[grasp][name]
        points = [{"knob": value, **figures} for value, figures in sorted(front.items())]
        summaries[name] = {"knob": knob, **front[knob], "front": points}
    return summaries


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


SLIP_CHANNELS = ("absent", "sound", "dead", "stuck", "noisy")
"""dead: flag and speed are 0, whatever slides; stuck: they say slip, whatever holds; noisy: some of the flags
are wrong, and the speed has the noise below besides; absent: not measured."""

WRONG_FLAGS, SPEED_NOISE_M_S = 0.02, 2e-3  # of a noisy slip channel
STUCK_SPEED_M_S = 1e-3  # that a stuck channel says
FLAG, SPEED = 6, 7  # columns of the sensed values (:class:`vegrip.hand_sample.HandSample`)


def wrong_slip(channel: str, seed: int) -> Callable[[Floats], None] | None:
    """Return what a slip channel does to the values of a sample, in place; None: nothing is wrong."""
    if channel == "noisy":
        rng = np.random.default_rng([seed, 4])

        def spoil(values: Floats) -> None:
            noise, wrong = rng.standard_normal(len(values)), rng.random(len(values)) < WRONG_FLAGS
            values[wrong, FLAG] = 1.0 - values[wrong, FLAG]
            values[:, SPEED] = np.maximum(values[:, SPEED] + SPEED_NOISE_M_S * noise, 0.0)

        return spoil
    said = {"dead": (0.0, 0.0), "stuck": (1.0, STUCK_SPEED_M_S)}.get(channel)
    if said is None:
        return None

    def say(values: Floats) -> None:
        values[:, [FLAG, SPEED]] = said

    return say


COLOURS = {
    "vegrip": "#0b6e4f", "learning": "#b8336a", "known": "#222222",
    "ellipse": "#7fb69f", "constant": "#8a8a8a",
    "cone": "#d1603d", "elastic": "#4a7bd0",
}  # fmt: skip


def draw_fronts(worlds: Mapping[str, Mapping[str, Any]], grasp: str, path: Path) -> None:
    """Draw the share of trials with a slip against the force over the least, of each world as in the JSON."""
    figure, panels = new_figure(len(worlds), size=(8.0, 5.0 * len(worlds)), share_x=True)
    for axes, (world, summaries) in zip(panels, worlds.items(), strict=True):
        for name, one in summaries.items():
            _draw_front(axes, name, one)
        axes.axvline(1.0, color="black", linewidth=0.8)
        axes.set_ylabel("trials with a slip [%]")
        axes.set_ylim(bottom=-1.0)
        axes.grid(alpha=0.25)
        axes.set_title(
            f"{grasp}, {world} world: every controller over its knob; squares: operating points with 95 %"
            " intervals",
            fontsize="medium",
        )
    panels[0].set_xlim(left=0.95)
    panels[-1].set_xlabel("grip force over the least possible force [-]")
    panels[0].legend(frameon=False)
    save_figure(figure, path, dpi=140)


def _draw_front(axes: "Axes", name: str, one: Mapping[str, Any]) -> None:
    front, colour = one["front"], COLOURS.get(name, "#000000")
    across = [point["force_over_least"] for point in front]
    up = [100.0 * point["trials_with_slip"] / point["trials"] for point in front]
    axes.plot(across, up, "o-", color=colour, markersize=4, linewidth=1.2, label=name)
    point = next(point for point in front if point["knob"] == one["knob"])
    at = point["force_over_least"], 100.0 * point["trials_with_slip"] / point["trials"]
    low, high = (100.0 * bound for bound in point["slip_probability_bounds"])
    axes.errorbar(
        *at, yerr=[[at[1] - low], [high - at[1]]], color=colour, capsize=3, linewidth=0.8, alpha=0.6
    )
    axes.plot(*at, "s", color=colour, markersize=10, fillstyle="none", markeredgewidth=1.6)
