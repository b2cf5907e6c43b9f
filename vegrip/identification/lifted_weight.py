"""A known weight in the hand: where in a recording it hangs still, and what each finger reads of it.

At rest the tangential forces of all fingers carry the weight, so with true magnitudes ``t_i`` and a mass m

    sum_i t_i = m g .

It holds while nothing accelerates: only rows count in which their sum stands still. Each finger's force is
taken as its share of the weight, because which way is down in the frame of a finger is not known. So the
pads face sideways, and what fingers push against each other along the surface counts as weight: the gain is
then too large. Zeros are those of the rows in the air before and after, else of the first rows.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError
from vegrip.identification.recording import Recording
from vegrip.identification.sensors import GRAVITY, TANGENTIAL_CHANNELS
from vegrip.types import Flags, Floats

BIN_S: Final = 0.05  # [s] of the grid on which the fingers meet
LONGEST_GAP_S: Final = 0.25  # [s] without a row, after which a finger is not known
STILL_S: Final = 0.5  # [s] for which all stands still: a swing of the arm is over, a breath is not
PIECE_S: Final = 1.0  # [s] after which a hold counts anew, for shares that drift
AIR_BINS: Final = 8  # in the air in a row, from which on there is a zero
EDGE_BINS: Final = 2  # of them at each end that are left out: a touch may begin before it shows
LASTING_BINS: Final = 4  # for which a movement lasts
TOUCHED: Final = 0.1  # of the greatest normal force, from which on a finger touches
OPEN: Final = 0.2  # of it, below which its least value is that in the air
LIFTED: Final = 0.3  # of m g: below it is not lifted (a gain is at least 0.5)
UNSTILL: Final = 0.02  # of m g by which a sum that stands still may move: 0.2 m/s^2 of the arm
CLEAR_STD: Final = 3.0  # standard deviations of a bin that are noise
WHOLE: Final = (
    0.7  # of a lift's usual sum: below it the table still carries (gains of 0.75 to 1.05 stay above)
)


@dataclass(frozen=True, slots=True)
class Hold:
    """Some time in which a weight hung still."""

    lift: int
    weight: float  # [N] m g
    loads: Floats  # (fingers,) [N] as they are read
    std: float  # [N] of their sum, by noise and what did not stand still
    zero_std: float  # [N] of their sum, by zeros that moved
    duration: float  # [s]
    is_zeroed_in_air: bool

    @property
    def total(self) -> float:
        return float(np.sum(self.loads))


@dataclass(frozen=True, slots=True)
class _Felt:
    """The tangential force of one finger on the grid."""

    force: Floats  # (m, 2) [N] without its zero
    zero_std: Floats  # (m,) [N]
    noise: float  # [N] of a component of a bin
    is_zeroed_in_air: bool


def find_holds(fingers: Mapping[str, Recording], mass: float, what: str, first: int = 0) -> list[Hold]:
    """Return where the weight of ``mass`` [kg] hung still in the recordings of all ``fingers``.

    Args:
        fingers: recordings with one clock.
        mass: that was lifted.
        what: name of the recordings in complaints.
        first: number of the first lift.

    Raises:
        RecordingError: one finger only, no tangential force, no lift, or one that never stood still.

    """
    _check(fingers, what)
    t, weight = _times(fingers, what), GRAVITY * mass
    felt = [_felt(each, t) for each in fingers.values()]
    total = np.sum([np.linalg.norm(each.force, axis=1) for each in felt], axis=0)
    lifts = list(_runs(total > LIFTED * weight, round(STILL_S / BIN_S)))
    if not lifts:
        highest = float(np.nanmax(total)) if np.any(np.isfinite(total)) else 0.0
        raise RecordingError(
            f"{what}: no weight of {mass:g} kg was lifted: the tangential forces sum to {highest:.2g} N at "
            f"most, and {weight:.3g} N are expected; begin with open fingers, lift it, and hold it still"
        )
    noise = math.hypot(*(one.noise for one in felt))
    still = _still(total, max(UNSTILL * weight, CLEAR_STD * noise))
    holds = [
        hold
        for number, rows in enumerate(lifts, first)
        for hold in _whole(_holds(felt, still, rows, weight, number))
    ]
    if not holds:
        raise RecordingError(
            f"{what}: the weight never hung still for {STILL_S:g} s; hold it still for three seconds"
        )
    return holds


def _check(fingers: Mapping[str, Recording], what: str) -> None:
    for name, recording in fingers.items():
        columns = recording.columns
        missing = [
            one for one in TANGENTIAL_CHANNELS if one not in columns or not np.any(np.isfinite(columns[one]))
        ]
        if missing:
            raise RecordingError(
                f"{what}: {name} has no {' and no '.join(missing)}; without them no weight is felt"
            )
    if len(fingers) < 2:
        raise RecordingError(
            f"{what}: holds {', '.join(fingers)} alone, and what the other side carries is not known; "
            "give the recordings of all fingers: the folder that vegrip record writes"
        )


def _times(fingers: Mapping[str, Recording], what: str) -> Floats:
    """Return the middles of the bins in which all fingers were recorded [s]."""
    begin = max(float(each.t[0]) for each in fingers.values())
    end = min(float(each.t[-1]) for each in fingers.values())
    if end - begin < 2.0 * STILL_S:
        raise RecordingError(
            f"{what}: all fingers together were recorded for {max(end - begin, 0.0):.2g} s; ten suffice"
        )
    return np.arange(begin, end - 0.5 * BIN_S, BIN_S) + 0.5 * BIN_S


def _felt(recording: Recording, t: Floats) -> _Felt:
    columns = recording.columns
    force = np.column_stack([_binned(recording.t, columns[name], t) for name in TANGENTIAL_CHANNELS])
    known = np.all(np.isfinite(force), axis=1)
    noise = _noise(recording)
    air = (
        known & _in_air(_binned(recording.t, columns["normal_force"], t))
        if "normal_force" in columns
        else ~known
    )
    open_ = [np.arange(rows.start, rows.stop)[EDGE_BINS:-EDGE_BINS] for rows in _runs(air, AIR_BINS)]
    zeros = open_ or [np.flatnonzero(known)[: AIR_BINS - 2 * EDGE_BINS]]
    times = [float(np.mean(t[rows])) for rows in zeros]
    levels = np.array([np.mean(force[rows], axis=0) for rows in zeros])
    zero = np.column_stack([np.interp(t, times, levels[:, axis]) for axis in range(2)])
    steps = np.concatenate(([0.0], np.linalg.norm(np.diff(levels, axis=0), axis=1), [0.0]))
    drift = steps[np.searchsorted(times, t)] / math.sqrt(
        12.0
    )  # between two zeros it may have gone at any time
    zero_std = np.hypot(drift, noise / math.sqrt(min(map(len, zeros))))
    return _Felt(force - zero, zero_std, noise, bool(open_))


def _noise(recording: Recording) -> float:
    """Return the noise of a component of a bin [N], by what changes from row to row."""
    steps = np.abs(np.concatenate([np.diff(recording.columns[name]) for name in TANGENTIAL_CHANNELS]))
    steps = steps[np.isfinite(steps)]
    row = 1.4826 / math.sqrt(2.0) * float(np.median(steps)) if len(steps) else 0.0
    rows = BIN_S * (len(recording) - 1) / recording.duration
    return row / math.sqrt(max(rows, 1.0))


def _binned(t: Floats, values: Floats, centres: Floats) -> Floats:
    """Return the mean of ``values`` around ``centres``, between rows that are rare; NaN in a gap."""
    there = np.isfinite(values)
    t, values = t[there], values[there]
    if not len(t):
        return np.full(len(centres), np.nan)
    place = np.floor((t - (centres[0] - 0.5 * BIN_S)) / BIN_S).astype(np.int64)
    inside = (place >= 0) & (place < len(centres))
    counts = np.bincount(place[inside], minlength=len(centres))
    sums = np.bincount(place[inside], values[inside], minlength=len(centres))
    found = np.where(counts > 0, sums / np.maximum(counts, 1), np.interp(centres, t, values))
    after = np.clip(np.searchsorted(t, centres), 1, len(t) - 1)
    is_gap = (counts == 0) & (t[after] - t[after - 1] > LONGEST_GAP_S)
    return np.where(is_gap, np.nan, found)


def _in_air(normal: Floats) -> Flags:
    """Return where a finger touches nothing; nowhere when it is never open."""
    if not np.any(np.isfinite(normal)):
        return np.zeros(len(normal), dtype=bool)
    low, high = np.nanquantile(normal, [0.02, 0.98])
    found: Flags = (normal < low + TOUCHED * (high - low)) & (low < OPEN * high)
    return found


def _still(total: Floats, allowed: float) -> Flags:
    """Return (m,) whether the sum of all forces stands still around a bin, within ``allowed`` [N]."""
    width = round(STILL_S / BIN_S)
    still = np.zeros(len(total), dtype=bool)
    windows = np.lib.stride_tricks.sliding_window_view(total, width)
    half = width // 2
    moved = np.abs(np.mean(windows[:, half:], axis=1) - np.mean(windows[:, :half], axis=1))
    quiet = (np.std(windows, axis=1) <= allowed) & (moved <= allowed)  # NaN is not
    for start in np.flatnonzero(quiet):
        still[start : start + width] = True
    return still


def _holds(felt: Sequence[_Felt], still: Flags, lift: slice, weight: float, number: int) -> Iterator[Hold]:
    inside = np.zeros(len(still), dtype=bool)
    inside[lift] = still[lift]
    for run in _runs(inside, round(STILL_S / BIN_S)):
        pieces = max((run.stop - run.start) // round(PIECE_S / BIN_S), 1)
        for rows in np.array_split(np.arange(run.start, run.stop), pieces):
            total = np.sum([np.linalg.norm(one.force[rows], axis=1) for one in felt], axis=0)
            yield Hold(
                number,
                weight,
                np.array([_load(one, rows) for one in felt]),
                float(np.std(total)) / math.sqrt(len(rows) / LASTING_BINS),
                math.hypot(*(float(np.mean(one.zero_std[rows])) for one in felt)),
                len(rows) * BIN_S,
                all(one.is_zeroed_in_air for one in felt),
            )


def _load(felt: _Felt, rows: NDArray[np.int64]) -> float:
    """Return the tangential force in ``rows`` [N]: the root of its mean square, without that of the noise."""
    square = float(np.mean(np.sum(felt.force[rows] ** 2, axis=1))) - 2.0 * felt.noise**2
    return math.sqrt(max(square, 0.0))


def _whole(holds: Iterator[Hold]) -> list[Hold]:
    """Return the holds of one lift in which nothing else carried."""
    found = list(holds)
    usual = float(np.median([hold.total for hold in found])) if found else 0.0
    return [hold for hold in found if hold.total >= WHOLE * usual]


def _runs(flags: Flags, shortest: int) -> Iterator[slice]:
    """Yield where ``flags`` are set for at least ``shortest`` rows."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    for begin, end in edges.reshape(-1, 2).tolist():
        if end - begin >= shortest:
            yield slice(begin, end)
