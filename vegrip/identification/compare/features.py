"""In which state the contact was when a row was measured: phase, depth, force, speed, times, loads."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.fit.preprocess import Measured
from vegrip.identification.fit.problem import AT, Problem
from vegrip.identification.fit.smoother import Floats

SLOW = 0.1  # [x_ref / s] below which a displacement is held, and below
RESTING = (
    0.1  # of the speed at which most of the way is gone: a testing machine may take a minute for a press
)
LOADED = 5.0  # standard deviations of a tangential load that is one
TURN = 0.05  # [s] after a turn that count as reversal

PHASES = ("out of contact", "loading", "hold", "unloading", "reversal", "sliding")


@dataclass(frozen=True, eq=False)
class Features:
    """One value per row of the recording, by name; ``phase`` are places in :data:`PHASES`.

    ``sticking`` are the rows that hold a tangential load and do not slide, in whatever phase.
    """

    phase: NDArray[np.int64]
    values: dict[str, Floats]
    sticking: NDArray[np.bool_] | None = None


def features_of(problem: Problem, table: Floats) -> Features:
    """Return the features of every row, from smoothed and predicted signals (noise must not sort rows)."""
    m = problem.measured
    t, columns = m.recording.t, m.recording.columns
    depth = m.motion.displacement
    speed = _speed(t, depth, m.first)
    force = table[:, AT["normal_force"]]
    touching = (problem.stiffness > 0.0) | (np.nan_to_num(m.force) > 5.0 * m.noise.normal_force)
    phase = np.full(t.size, PHASES.index("hold"))
    moving = _moving(speed, problem.depth)
    phase[speed > moving] = PHASES.index("loading")
    phase[speed < -moving] = PHASES.index("unloading")
    phase[_turning(t, speed, moving, m.first)] = PHASES.index("reversal")
    phase[m.sliding] = PHASES.index("sliding")
    phase[~touching] = PHASES.index("out of contact")
    none = np.zeros(t.size)
    values = {
        "indentation": depth,
        "normal_force": force,
        "speed": np.abs(speed),
        "time_in_contact": _since(t, touching, m.first),
        "time_in_episode": t - t[np.maximum.accumulate(np.where(m.first > 0.5, np.arange(t.size), 0))],
        "time": t - t[0],
        "episode": problem.episodes.astype(np.float64),
        "tangential_force": np.nan_to_num(
            np.hypot(columns.get("tangential_force_x", none), columns.get("tangential_force_y", none))
        ),
        "frequency": _frequency(t, speed, moving, m.first),
    }
    if "temperature" in columns:
        values["temperature"] = np.nan_to_num(
            columns["temperature"], nan=float(np.nanmean(columns["temperature"]))
        )
    return Features(phase, values, _sticking(m, touching & (phase != PHASES.index("sliding"))))


def _moving(speed: Floats, depth: float) -> float:
    """Return the speed [m/s] above which the tip moves; ``depth``: the reference depth [m]."""
    way = float(np.sum(np.abs(speed)))
    usual = float(np.sum(speed**2)) / way if way > 0.0 else 0.0
    return min(SLOW * depth, RESTING * usual)


def _sticking(m: Measured, rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    columns = m.recording.columns
    loaded = np.zeros(rows.size, dtype=bool)
    for name, noise in (
        ("tangential_force_x", m.noise.tangential_force),
        ("tangential_force_y", m.noise.tangential_force),
        ("torque_z", m.noise.torque_z),
    ):
        if name in columns and noise > 0.0:
            loaded |= np.abs(np.nan_to_num(columns[name])) > LOADED * noise
    slips: NDArray[np.bool_] = columns.get("slip", np.zeros(rows.size)) == 1.0
    sticks: NDArray[np.bool_] = rows & loaded & ~slips
    return sticks


def _speed(t: Floats, depth: Floats, first: Floats) -> Floats:
    """Return the speed [m/s] over five samples, of each episode by itself."""
    out = np.zeros(t.size)
    starts = np.flatnonzero(first > 0.5)
    for a, b in zip(starts, [*starts[1:], t.size], strict=True):
        if b - a > 5:
            raw = np.gradient(depth[a:b], t[a:b])
            out[a:b] = np.convolve(np.pad(raw, 2, mode="edge"), np.full(5, 0.2), mode="valid")
    return out


def _turns(speed: Floats, moving: float, first: Floats) -> NDArray[np.int64]:
    """Return rows at which the direction of motion changes, rests in between not counted."""
    direction = np.where(speed > moving, 1, np.where(speed < -moving, -1, 0))
    rows = np.flatnonzero(direction)
    turned = np.flatnonzero(np.diff(direction[rows]) != 0)
    episode = np.cumsum(first > 0.5)
    return np.array([rows[i + 1] for i in turned if episode[rows[i]] == episode[rows[i + 1]]], dtype=np.int64)


def _turning(t: Floats, speed: Floats, moving: float, first: Floats) -> NDArray[np.bool_]:
    out = np.zeros(t.size, dtype=bool)
    for row in _turns(speed, moving, first):
        out[row : np.searchsorted(t, t[row] + TURN)] = True
    return out


def _frequency(t: Floats, speed: Floats, moving: float, first: Floats) -> Floats:
    """Return how often per second the motion goes back and forth about each row, over a second [Hz]."""
    at = t[_turns(speed, moving, first)]
    return (np.searchsorted(at, t + 0.5) - np.searchsorted(at, t - 0.5)) / 2.0


def _since(t: Floats, touching: NDArray[np.bool_], first: Floats) -> Floats:
    """Return the time since the contact was made [s]; 0 out of contact."""
    starts = touching & (np.r_[True, ~touching[:-1]] | (first > 0.5))
    began = np.maximum.accumulate(np.where(starts, np.arange(t.size), 0))
    return np.where(touching, t - t[began], 0.0)
