"""Where a model fails: the regimes that hold most of what noise cannot explain, each as a sentence.

The misfit of a row is ``z^2 - 1``, z the residual over its standard deviation: zero on average where the
model is right. A regime is a phase, a third of a variable, or both; reported are those with a large share
of the misfit in few rows, one after the other, each without the rows of those before.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.fit.preprocess import Measured
from vegrip.identification.fit.problem import AT, Problem
from vegrip.types import Floats

HELD_SPEED = 0.1  # [x_ref / s] below which a displacement is held, and below
# of the speed at which most of the way is gone: a testing machine may take a minute for a press
RESTING_SPEED_SHARE = 0.1
LOADED = 5.0  # standard deviations of a tangential load that is one
TURN = 0.05  # [s] after a turn that count as reversal
PHASES = ("out of contact", "loading", "hold", "unloading", "reversal", "sliding")
SPOKEN_UNITS: Final = {
    "normal_force": "N",
    "tangential_force": "N",
    "displacement": "m",
    "indentation": "m",
    "contact_radius": "m",
    "torque_z": "N m",
    "speed": "m/s",
    "slip_speed": "m/s",
    "time": "s",
    "time_in_contact": "s",
    "time_in_episode": "s",
    "temperature": "degC",
    "frequency": "Hz",
    "episode": "",
}
SAID: Final = {
    "normal_force": "at {} of normal force",
    "tangential_force": "at {} of tangential force",
    "indentation": "at a depth of {}",
    "speed": "at {}",
    "time": "{} after the start",
    "time_in_contact": "{} into the contact",
    "time_in_episode": "{} into the episode",
    "temperature": "at {}",
    "frequency": "at {}",
    "episode": "in episode {}",
}
PREFIX: Final = {-3: "n", -2: "u", -1: "m", 0: "", 1: "k"}
MAX_REGIMES = 6
LEAST_SHARE = 0.03
MIN_REGIME_ROWS = 10
OUT_OF_CONTACT = "out of contact"
EVERYWHERE = "everywhere"
EXCESS_STDS = 5.0  # standard deviations of a sum of squares of noise
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Features:
    """One value per row of the recording, by name; ``phase`` are places in :data:`PHASES`.

    ``sticking`` are the rows that hold a tangential load and do not slide, in whatever phase.
    """

    phase: NDArray[np.int64]
    values: dict[str, Floats]
    sticking: NDArray[np.bool_]


def features_of(problem: Problem, u: Floats) -> Features:
    """Return the features of every row, from smoothed and predicted signals (noise must not sort rows).

    Depth and normal force are without the zeros of their sensors.
    """
    m, table = problem.measured, problem.table(u)
    t, columns = m.recording.t, m.recording.columns
    depth = problem.depth_at_rest(u)
    speed = _speed(t, depth, m.first)
    force = table[:, AT["normal_force"]]
    unforeseen = np.nan_to_num(m.force - force) > 5.0 * m.noise.normal_force  # zero of the sensor left out
    touching = (problem.stiffness > 0.0) | unforeseen
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
        "normal_force": force - problem.parts(u)[1][1],
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
    for name in {"temperature", "age"} & columns.keys():
        values[name] = np.nan_to_num(columns[name], nan=float(np.nanmean(columns[name])))
    return Features(phase, values, _sticking(m, touching & (phase != PHASES.index("sliding"))))


def _moving(speed: Floats, depth: float) -> float:
    """Return the speed [m/s] above which the tip moves; ``depth``: the reference depth [m]."""
    way = float(np.sum(np.abs(speed)))
    usual = float(np.sum(speed**2)) / way if way > 0.0 else 0.0
    return min(HELD_SPEED * depth, RESTING_SPEED_SHARE * usual)


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


def format_quantity(name: str, value: float) -> str:
    """Return ``value`` of a channel or variable with its unit, two digits."""
    return format_amount(value, SPOKEN_UNITS.get(name, ""))


def format_amount(value: float, unit: str) -> str:
    """Return ``value`` with its unit, and a prefix where that has one; two digits."""
    if unit in ("", "degC", "s", "Hz", "K", "kg", "rad") or unit.startswith("1/") or value == 0.0:
        return f"{value:.0f} {unit}".strip() if abs(value) >= 100.0 else f"{value:.2g} {unit}".strip()
    power = min(max(math.floor(math.log10(abs(value)) / 3.0), -3), 1)
    if unit.startswith("m") and power == 1:
        power = 0
    scaled = value / 10.0 ** (3 * power)
    digits = f"{scaled:.2g}" if abs(scaled) < 100.0 else f"{scaled:.0f}"
    return f"{digits} {PREFIX[power]}{unit}"


def format_span(name: str, low: float | None, high: float | None) -> str:
    """Return a range in words."""
    if name == "frequency" and not low:
        return "without going to and fro" if low is None else "while going to and fro"
    if low is None and high is not None:
        text = f"up to {format_quantity(name, high)}"
    elif high is None and low is not None:
        text = f"more than {format_quantity(name, low)}"
    elif low is not None and high is not None:
        text = f"{format_quantity(name, low)} to {format_quantity(name, high)}"
    else:
        text = "any"
    return SAID.get(name, f"{name} {{}}").format(text)


def format_height(low: float | None, high: float | None) -> str:
    """Return a range of depths out of contact in words: heights above the surface at rest."""
    if high is not None and high < 0.0:
        near = format_quantity("indentation", -high)
        if low is None:
            return f"more than {near} from the surface"
        return f"{near} to {format_quantity('indentation', -low)} from the surface"
    if high is None and low is not None and low < 0.0:
        return f"closer than {format_quantity('indentation', -low)} to the surface"
    return format_span("indentation", low, high)


@dataclass(frozen=True)
class Regime:
    """A regime in which the model fails."""

    channel: str  # whose residual
    regime: str  # short name
    share: float  # of all misfit of the recording
    offset: float  # mean of measured less model, in the unit of the channel
    rms: float  # of the residual there
    rows: int  # how many
    note: str  # a sentence


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of one channel: rows of the recording, in its unit, standardised."""

    channel: str
    rows: NDArray[np.int64]
    raw: Floats
    z: Floats


def where(residuals: list[Residuals], features: Features) -> list[Regime]:
    """Return the regimes that hold the misfit, largest share first; none where all is noise."""
    excess = [r.z**2 - 1.0 for r in residuals]
    sums = [float(e.sum()) for e in excess]
    total = sum(
        s for s, e in zip(sums, excess, strict=True) if s > EXCESS_STDS * math.sqrt(2.0 * max(e.size, 1))
    )
    count = sum(e.size for e in excess)
    if total <= 0.0:
        return []
    left = [np.ones(e.size, dtype=bool) for e in excess]
    found: list[Regime] = []
    candidates = [list(_candidates(r, features)) for r in residuals]
    while len(found) < MAX_REGIMES:
        best: tuple[float, int, str, Mask] | None = None
        for i, regimes in enumerate(candidates):
            for name, mask in regimes:
                here = mask & left[i]
                n = int(np.count_nonzero(here))
                if n < MIN_REGIME_ROWS:
                    continue
                share = float(excess[i][here].sum()) / total
                if share < LEAST_SHARE or share * total < EXCESS_STDS * math.sqrt(2.0 * n):
                    continue
                score = share * math.log(max(share, 1e-9) * count / n) if share * count > n else 0.0
                if best is None or score > best[0]:
                    best = (score, i, name, here)
        if best is None:
            break
        _, i, name, here = best
        found.append(_regime(residuals[i], name, here, float(excess[i][here].sum()) / total))
        left[i] &= ~here
    return sorted(found, key=lambda one: -one.share)


def _candidates(residuals: Residuals, features: Features) -> Iterator[tuple[str, Mask]]:
    """Yield names and rows: phases, thirds of each variable, and thirds within each phase."""
    phase = features.phase[residuals.rows]
    yield EVERYWHERE, np.ones(phase.size, dtype=bool)
    present = [p for p in range(len(PHASES)) if np.count_nonzero(phase == p) >= MIN_REGIME_ROWS]
    for p in present:
        yield PHASES[p], phase == p
    if np.count_nonzero(sticking := features.sticking[residuals.rows]) >= MIN_REGIME_ROWS:
        yield "sticking", sticking
    for name, values in features.values.items():
        here = values[residuals.rows]
        for group in (None, *present):
            rows = np.ones(phase.size, dtype=bool) if group is None else phase == group
            for text, mask in _thirds(name, here, rows, is_away=group == PHASES.index(OUT_OF_CONTACT)):
                yield (text if group is None else f"{PHASES[group]} {text}"), mask


def _thirds(name: str, values: Floats, rows: Mask, *, is_away: bool) -> Iterator[tuple[str, Mask]]:
    said = format_height if is_away and name == "indentation" else partial(format_span, name)
    low, high = (float(q) for q in np.quantile(values[rows], (1.0 / 3.0, 2.0 / 3.0)))
    if values[rows].max() <= values[rows].min():
        return
    if low > values[rows].min():
        yield said(None, low), rows & (values <= low)
    if high > low > values[rows].min() and format_quantity(name, high) != format_quantity(name, low):
        yield said(low, high), rows & (values > low) & (values <= high)
    if high < values[rows].max() and format_quantity(name, high) != format_quantity(
        name, float(values[rows].max())
    ):
        yield said(high, None), rows & (values > high)


def _regime(residuals: Residuals, name: str, here: Mask, share: float) -> Regime:
    raw = residuals.raw[here]
    name = "elsewhere" if name == EVERYWHERE and here.size > np.count_nonzero(here) else name
    offset, rms = float(np.mean(raw)), math.sqrt(float(np.mean(raw**2)))
    if abs(offset) > 0.5 * rms:
        amount = format_quantity(residuals.channel, abs(offset))
        fails = f"the model reads {amount} {'low' if offset > 0 else 'high'}"
    else:
        fails = f"the model is {format_quantity(residuals.channel, rms)} off, now above and now below"
    if name.startswith(OUT_OF_CONTACT) and residuals.channel == "normal_force" and offset < -0.5 * rms:
        fails += " (a pull that it lacks)"
    note = f"{residuals.channel}, {name}: {fails}, {100.0 * share:.0f} % of the misfit"
    return Regime(residuals.channel, name, share, offset, rms, int(np.count_nonzero(here)), note)
