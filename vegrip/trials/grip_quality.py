"""How good a grip is: its force over the least possible force, and how near it came to slipping.

The **least possible force** at an instant is that of a controller that knows the truth: of every finger the
normal force N at which its present load lies on the limit surface,

    ``gauge(k, f / (mu N), m / (mu N a(N))) = 1``,   ``a(N) = a (N / N_now)^(1/3)``,

with the true friction, radius and exponent; of the grasp, the larger of the thumb's and of the sum of the
others'. The load is shared among the fingers as it is. It is instantaneous: drives that lag, and loads that
come in bursts, keep every real controller above it.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import betaincinv

from vegrip.trials.closed_loop import Course
from vegrip.trials.known_contact import least_force
from vegrip.trials.scenario import SETTLED_S
from vegrip.types import Floats
from vegrip.virtual import Disturbance
from vegrip.virtual.disturbance import AddedMass, Push, Shake, SlowLoad, Turn, Twist, Wetting

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
    friction_error: Floats  # (n, fingers) stated less true ln mu, in standard deviations; NaN = no contact
    friction_std: Floats  # (n, fingers) of ln mu as stated
    lags: Floats = field(default_factory=lambda: np.zeros(0))  # (m,) [s] of the drives, as far as known


def least_forces(course: Course) -> Floats:
    """Return the least possible force [N] of each finger at every time of ``course``; (n, fingers)."""
    forces, contacts = np.array(course.force), np.array(course.contact).reshape(-1, 5)
    rows = zip(forces.ravel().tolist(), contacts.tolist(), strict=True)
    least = [least_force(force, *contact) for force, contact in rows]
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


def record_of(course: Course, events: Sequence[Disturbance], lift_start: float) -> GripRecord:
    """Return the record of ``course`` from ``lift_start`` [s] on."""
    time = np.array(course.time)
    kept = time >= lift_start
    time = time[kept]
    stated, mu = np.array(course.stated)[kept], np.array(course.contact)[kept, :, 2]
    error, std = stated[:, :, 0] - np.log(mu), stated[:, :, 1]
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
