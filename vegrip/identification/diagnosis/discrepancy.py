"""The variable that a misfit depends on, and the curve over it, when no effect of the catalogue explains it.

For each variable the residual is regressed on a curve over it, a Gaussian process on a linear spline

    ``w = B c + J v + e``,   ``c ~ N(0, s^2 C)``,   ``C_ij = exp(-(k_i - k_j)^2 / 2 l^2)``,   ``e ~ N(0, 1)``

beside the derivatives J of the model with their priors: a curve that only does what a parameter could do
explains nothing, [BrynjarsdottirOHagan2014]_. Size s and length l are those of the greatest evidence, which
pays for every bend [RasmussenWilliams2006]_, and the variable with the greatest evidence is reported. The
curve is a hint for the author of the missing effect, not physics.
"""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from vegrip.identification.compare.where import Features, features_of
from vegrip.identification.diagnosis.candidate_fit import CandidateFit
from vegrip.identification.diagnosis.change_point import Change, find_change
from vegrip.identification.diagnosis.thresholds import MIN_POINTING_NATS
from vegrip.identification.fit.problem import AT, Problem
from vegrip.types import Floats

KNOTS = 49
LENGTHS = (0.5, 0.15, 0.05)  # of the range: a trend, a bend, a ripple
PRIOR_SIZES = np.logspace(
    -4.0, 4.0, 33
)  # s, times the size at which a curve of one bend is as large as the noise
JITTER = 1e-9
OUTER = {"temperature": 0.2, "age": 0.0}  # and what they have to scatter by
SLOW_VARIABLES = ("time", *OUTER)  # over which a stiffness may change
MIN_CURVE_ROWS = 20
PLACE_OF = {"below_deepest": "memory", "time_in_contact": "memory", "time": "drift", "age": "drift"}
"""Where an error is that depends on them; in the force law, where it depends on what the moment shows."""


@dataclass(frozen=True)
class Discrepancy:
    """The curve that explains most of what is left."""

    variable: str  # time, displacement, normal_force, speed, direction, ...
    channel: str  # whose residual
    gain: float  # of evidence [nats]
    share: float  # of the misfit of that channel that it takes
    at: list[float]  # knots [unit of the variable]
    value: list[float]  # measured less model there [N, or relative load at slip, or m]
    times: str  # what the value is multiplied by, "normal_force" for a stiffness that changes; or nothing
    others: dict[str, float]  # variable -> gain, of the next best ones
    change: Change | None = None  # of the stiffness at one place, where that has more evidence than any curve
    places: dict[str, float] = dataclasses.field(default_factory=dict)  # place of the error -> best gain

    @property
    def place(self) -> str:
        """Where the error is: in the law of the moment or in the state [EbersSteeleKutz2024]_."""
        best = max(self.places.values())
        return " or ".join(name for name, gain in self.places.items() if gain >= best - MIN_POINTING_NATS)

    @property
    def note(self) -> str:
        depends = f"what is left depends on {self.variable} ({self.channel})"
        more = f"; the error is in the {self.place}" if self.change is None else f": {self.change.note}"
        return depends + more

    def as_dict(self) -> dict[str, Any]:
        """Return it for JSON; where the change is: ``at``, ``interval``, ``change``, ``std``, ``error``."""
        shape = {"at": self.at, "residual": self.value, "times": self.times}
        return (dataclasses.asdict(self.change) if self.change is not None else {}) | {
            "variable": self.variable, "channel": self.channel, "gain": self.gain, "share": self.share,
            "place": self.place, "places": self.places,
            "shape": shape, "others": self.others, "note": self.note,
        }  # fmt: skip


class Refit(NamedTuple):
    """The linear refit of the whole model: a curve of one channel gives way to it as all channels allow."""

    information: Floats  # (unknowns, unknowns), priors included
    pull: Floats  # (unknowns,) of residual and priors, 0 at the optimum


def _refit_of(fitted: CandidateFit) -> Refit:
    best, k = fitted.optimum, fitted.problem.unknowns
    J = best.jacobian
    return Refit(J.T @ J + np.diag(k.std**-2.0), J.T @ best.residual + (best.u - k.prior) / k.std**2)


def friction_trend(fitted: CandidateFit) -> float:
    """Return the evidence [nats] of a friction that changes slowly with time, whatever the slips are like."""
    problem, best = fitted.problem, fitted.optimum
    channel, rows, block = next(one for one in _blocks(problem) if one[0] == "tangential_force")
    if rows.size < MIN_CURVE_ROWS:
        return 0.0
    t = problem.measured.recording.t[rows]
    knots = _knots(t, min(KNOTS, rows.size // 5))
    if knots.size < 2:
        return 0.0
    B = _whitened(problem, _tents(t, knots), channel, rows)
    return _curve(best.residual[block], best.jacobian[block], _refit_of(fitted), B, knots, LENGTHS[:1])[0]


def find_discrepancy(fitted: CandidateFit, *, with_changes: bool = False) -> Discrepancy | None:
    """Return the curve with the greatest evidence; None when none has enough.

    ``with_changes``: look for a change of the stiffness at one place as well.
    """
    problem, u = fitted.problem, fitted.optimum.u
    table = problem.table(u)
    features = features_of(problem, u)
    found: list[Discrepancy] = []
    r, J, refit = fitted.optimum.residual, fitted.optimum.jacobian, _refit_of(fitted)
    for channel, rows, block in _blocks(problem):
        if rows.size < MIN_CURVE_ROWS:
            continue
        w = r[block]
        scales = {"": np.ones(rows.size)}
        if channel == "normal_force":
            scales["normal_force"] = np.maximum(features.values["normal_force"], 0.0)
        for name, values in _variables(problem, features, table, rows, channel):
            knots = _knots(values, min(KNOTS, w.size // 5))
            if knots.size < 2:
                continue
            for times, scale in scales.items():
                if times and name not in SLOW_VARIABLES:
                    continue
                B = _whitened(problem, _tents(values, knots) * scale[:, None], channel, rows)
                if not np.isfinite(B).all():  # the model diverges, as where its branches relax more than all
                    continue
                gain, share, curve = _curve(w, J[block], refit, B, knots)
                at, value = knots.tolist(), curve.tolist()
                found.append(Discrepancy(name, channel, gain, share, at, value, times, {}))
    best = max(found, key=lambda one: one.gain, default=None)
    if best is None or best.gain <= MIN_POINTING_NATS:
        return None
    is_step = problem.measured.recording.is_step  # which shows no place
    change = find_change(fitted, best.gain) if with_changes and not is_step else None
    if change is not None and change.gain > best.gain:
        same = [one for one in found if (one.variable, one.channel) == (change.variable, "normal_force")]
        best = dataclasses.replace(max(same, key=lambda one: one.gain), gain=change.gain, change=change)
    gains: dict[str, float] = {}
    for one in found:
        gains[one.variable] = max(one.gain, gains.get(one.variable, -math.inf))
    others = sorted(((g, n) for n, g in gains.items() if n != best.variable), reverse=True)[:4]
    places: dict[str, float] = {}
    for name, gain in gains.items():
        place = PLACE_OF.get(name, "force law")
        places[place] = max(gain, places.get(place, -math.inf))
    return dataclasses.replace(best, others={n: g for g, n in others}, places=places)


def _knots(values: Floats, count: int) -> Floats:
    """Return about ``count`` knots, half of them where the rows are and half evenly over the range."""
    half = count // 2 + 1
    evenly = np.linspace(float(values.min()), float(values.max()), half)
    dense = np.quantile(values, np.linspace(0.0, 1.0, half))
    knots = np.unique(np.r_[evenly, dense])
    least = 0.2 * float(np.ptp(values)) / max(count, 1)
    keep = np.r_[True, np.diff(knots) > least]
    return knots[keep]


def _blocks(problem: Problem) -> Iterator[tuple[str, np.ndarray, slice]]:
    m = problem.measured
    n, k = len(m.recording), m.sliding.size
    yield "normal_force", np.arange(n), slice(0, n)
    yield "tangential_force", m.sliding, slice(n, n + k)
    yield "contact_radius", m.seen, slice(n + k, n + k + m.seen.size)


def _variables(
    problem: Problem, features: Features, table: Floats, rows: np.ndarray, channel: str
) -> Iterator[tuple[str, Floats]]:
    f, depth = features.values, features.values["indentation"]
    t = problem.measured.recording.t
    speed = np.gradient(depth, t)
    speed[np.r_[False, np.diff(problem.episodes) != 0] | np.r_[np.diff(problem.episodes) != 0, False]] = 0.0
    rate = speed / problem.depth
    deepest = np.maximum.accumulate(depth)
    every = {
        "displacement": depth,
        "normal_force": f["normal_force"],
        "speed": np.arcsinh(rate),
        "direction": np.sign(np.where(np.abs(rate) > 0.1, rate, 0.0)) * problem.stiffness,
        "below_deepest": np.where(depth > 0.0, deepest - depth, 0.0),
        "time_in_contact": np.log10(f["time_in_contact"] + 0.01),
        "time": f["time"],
        "tangential_force": f["tangential_force"],
        "contact": (problem.stiffness > 0.0).astype(np.float64),
    }
    if problem.measured.recording.is_step:
        del every["time"]  # steps are joined in any order
    every |= {name: f[name] for name, least in OUTER.items() if name in f and np.std(f[name]) > least}
    if channel == "tangential_force":
        slip = problem.measured.recording.columns.get("slip_speed")
        if slip is not None:
            every["slip_speed"] = np.log10(np.abs(np.nan_to_num(slip)) / problem.depth + 1e-3)
        torque = np.nan_to_num(table[:, AT["torque_z"]])
        pull = np.nan_to_num(table[:, AT["tangential_force"]])
        radius = np.maximum(table[:, AT["contact_radius"]], 1e-300)
        every["torque_share"] = np.arctan2(np.abs(torque) / radius, np.abs(pull))
    for name, values in every.items():
        yield name, values[rows]


def _tents(values: Floats, knots: Floats) -> Floats:
    out = np.zeros((values.size, knots.size))
    for j in range(knots.size):
        unit = np.zeros(knots.size)
        unit[j] = 1.0
        out[:, j] = np.interp(values, knots, unit)
    return out


def _whitened(problem: Problem, B: Floats, channel: str, rows: np.ndarray) -> Floats:
    if channel == "normal_force":
        return problem.whitener(B)
    std: Floats = problem.slip_std if channel == "tangential_force" else problem.radius_std
    scaled: Floats = B / std[: rows.size, None]
    return scaled


def _curve(
    w: Floats, J: Floats, refit: Refit, B: Floats, knots: Floats, lengths: tuple[float, ...] = LENGTHS
) -> tuple[float, float, Floats]:
    """Return the evidence of the best curve [nats], the share of the misfit that it takes, and the curve."""
    across = B.T @ J
    M = B.T @ B - across @ np.linalg.solve(refit.information, across.T)
    b = B.T @ w - across @ np.linalg.solve(refit.information, refit.pull)
    unit = math.sqrt(knots.size / max(float(np.trace(M)), 1e-300))
    best = (-math.inf, np.zeros(knots.size))
    for length in lengths:
        apart = (knots[:, None] - knots) / (length * float(np.ptp(knots)))
        L = np.linalg.cholesky(np.exp(-0.5 * apart**2) + JITTER * np.eye(knots.size))
        d, V = np.linalg.eigh(L.T @ M @ L)
        d, along = np.maximum(d, 0.0), V.T @ (L.T @ b)
        for s2 in (unit * PRIOR_SIZES) ** 2:
            gain = 0.5 * float(np.sum(along**2 * s2 / (1.0 + s2 * d)) - np.sum(np.log1p(s2 * d)))
            if gain > best[0]:
                best = (gain, L @ (V @ (along * s2 / (1.0 + s2 * d))))
    gain, curve = best
    power = float(w @ w)
    share = float(2.0 * curve @ b - curve @ M @ curve) / power if power > 0.0 else 0.0
    return gain, share, curve
