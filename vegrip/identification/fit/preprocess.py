"""A recording made ready for a fit: smoothed motion, outliers taken out, which rows inform which channel."""

import dataclasses
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError
from vegrip.identification.fit.gaps import NO_GAPS, find_gaps
from vegrip.identification.fit.motion import Motion, motion_of
from vegrip.identification.fit.noise import LEAST_AIR, Noise, in_air
from vegrip.identification.recording import Recording
from vegrip.types import Floats

AROUND = 6  # samples to either side that say what is usual
MIN_SUDDEN_RATIO = 10.0  # times the steepest of those
MIN_FORCE_NOISES = 30.0  # of the force
MIN_FORCE_SHARE = 0.3  # of the force must be left, else the contact parted
RECOVERY_FACTOR = 2.0  # times as long as it took to regain the lost force is left out
Mask = NDArray[np.bool_]
SPIKE = 8.0  # standard deviations off the line through both neighbours
MIN_FIT_ROWS = 50
LONGEST_STRETCH = 20  # rows, and
SLIP_LOAD_WINDOW_S = 0.1  # [s] over which loads at slip are averaged
LOADS_AT_SLIP = {"tangential_force_x", "tangential_force_y", "torque_z"}
AVERAGED = {"normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "slip_speed"}


@dataclass(frozen=True)
class Event:
    """A loss of force: row after which it begins, first row that counts again, time [s] and size [N]."""

    begin: int
    end: int
    time: float
    loss: float

    @property
    def rows(self) -> slice:
        return slice(self.begin + 1, self.end)


def find_events(t: Floats, first: Floats, displacement: Floats, force: Floats, noise: float) -> list[Event]:
    """Return the sudden losses of ``force`` (n,) [N], NaN where missing, with white ``noise`` [N].

    The material slipped or tore, and recovers. No effect of a contact model makes them, and one such event
    pulls every parameter. A loss counts when the force falls between neighbouring samples by far more than
    the noise and ten times faster than around it, while the displacement goes on as before and the contact
    stays closed (a pull-off ends in air and is no event).

    Usual is the steepest change before a loss, and the middle one after it (the force springs back a little).
    """
    found: list[Event] = []
    fall, move = -np.diff(force), np.abs(np.diff(displacement))
    fall[first[1:] > 0.0] = np.nan
    ends = np.append(np.flatnonzero(first > 0.0), t.size)  # of the episodes
    for i in np.flatnonzero(np.nan_to_num(fall) > MIN_FORCE_NOISES * noise).tolist():
        if found and i < found[-1].end:
            continue
        before, after = slice(max(i - AROUND, 0), i), slice(i + 3, i + 3 + AROUND)
        usual, moved = np.abs(fall[before]), np.r_[move[before], move[after]]
        if usual.size < AROUND or not np.isfinite(np.r_[usual, fall[after]]).all():
            continue
        usually = max(float(usual.max()), float(np.median(np.abs(fall[after]))) if fall[after].size else 0.0)
        low = force[i + 1 : i + 4].min()
        if (
            force[i] - low > MIN_SUDDEN_RATIO * usually
            and move[i] <= 2.0 * moved.max()
            and low > MIN_FORCE_SHARE * force[i] > 0.0
        ):
            found.append(_event(i, t, int(ends[np.searchsorted(ends, i, side="right")]), force, low))
    return found


def _event(i: int, t: Floats, last: int, force: Floats, low: float) -> Event:
    """Follow an event until the force has long been back; at most to ``last``, the end of its episode."""
    back = np.flatnonzero(force[i + 1 : last] >= force[i])
    if not back.size:
        return Event(i, last, float(t[i + 1]), float(force[i] - low))
    again = t[i] + RECOVERY_FACTOR * (t[i + 1 + int(back[0])] - t[i])
    end = min(int(np.searchsorted(t, again, side="right")), last)
    return Event(i, end, float(t[i + 1]), float(force[i] - low))


@dataclass(frozen=True, eq=False)
class Measured:
    """A recording ready for a fit."""

    recording: Recording  # as it was read
    noise: Noise  # of its sensors
    motion: Motion  # smoothed displacement and its error
    first: Floats  # (n,) 1 where an episode begins
    force: Floats  # (n,) [N], NaN where missing or an outlier
    # (k,) rows in the middle of short stretches in which the whole contact slides under a load
    sliding: NDArray[np.int64]
    stretch: NDArray[np.int64]  # (k,) how many rows each stretch has
    seen: NDArray[np.int64]  # (m,) rows with a contact radius
    outliers: dict[str, int]  # channel -> how many rows were taken out
    tare: dict[str, float]  # channel -> what it showed in air, which was taken off
    events: tuple[Event, ...] = ()  # sudden losses of force, whose rows were taken out
    gaps: NDArray[np.int64] = field(default_factory=NO_GAPS.copy)  # (gaps, 2) the rows beside each gap

    @property
    def recovered(self) -> bool:
        """Whether the contact had recovered before each episode; a recording may say that it had not."""
        return bool(self.recording.source.get("recovered", True))

    @property
    def columns(self) -> dict[str, Floats]:
        """Columns for the prediction: smoothed displacement, loads averaged over each stretch of slip.

        Averaged, because the load at slip is not linear in noise: where the noise of the torque is a third of
        the torque at slip, a pull seems to reach five percent beyond the limit surface.
        """
        recording = self.recording
        episode = recording.episode.astype(np.float64) if self.recovered else np.zeros(len(recording))
        columns = {
            "t": recording.t,
            "episode": episode,
            **recording.columns,
            "normal_force": self.force,
            "displacement": self.motion.displacement,
        }
        for name in AVERAGED & set(columns):
            columns[name] = columns[name].copy()
            for row, count in zip(self.sliding.tolist(), self.stretch.tolist(), strict=True):
                here = columns[name][row - count // 2 : row - count // 2 + count]
                columns[name][row] = np.nan if np.all(np.isnan(here)) else np.nanmean(here)
        return columns


def lacking_rows(recording: Recording) -> str:
    """Return of which channel ``recording`` has too few rows for a fit, else nothing."""
    for channel in ("displacement", "normal_force"):
        if np.count_nonzero(np.isfinite(recording.columns[channel])) < MIN_FIT_ROWS:
            return f"{recording.name} has fewer than {MIN_FIT_ROWS} rows with {channel}"
    return ""


def preprocess(recording: Recording, noise: Noise) -> Measured:
    """Make ``recording`` ready.

    Raises:
        RecordingError: it has no displacement, no normal force, or too little of either.

    """
    for channel in ("displacement", "normal_force"):
        if channel not in recording.columns:
            raise RecordingError(
                f"{recording.name} has no {channel}, and a fit compares normal force and displacement; "
                f"import it with --map {channel}=COLUMN"
            )
    if lacking := lacking_rows(recording):
        raise RecordingError(lacking)
    recording, tare = tare_channels(without_lost_rows(recording))
    first = np.r_[1.0, (np.diff(recording.episode) != 0).astype(np.float64)]
    depth, force = (recording.columns[name].copy() for name in ("displacement", "normal_force"))
    wild = {"displacement": find_spikes(depth, noise.displacement or np.inf, first)}
    wild["normal_force"] = find_spikes(force, noise.normal_force, first)
    depth[wild["displacement"]] = np.nan
    force[wild["normal_force"]] = np.nan
    lost = tuple(find_events(recording.t, first, depth, force, noise.normal_force))
    for one in lost:
        force[one.rows] = np.nan
    return Measured(
        recording,
        noise,
        motion_of(recording.t, first, depth, noise.displacement),
        first,
        force,
        *stretches(recording.t, _sliding(recording, noise), first),
        _seen(recording, noise),
        {name: int(np.count_nonzero(rows)) for name, rows in wild.items() if rows.any()},
        tare,
        lost,
        NO_GAPS if recording.is_step else find_gaps(recording.t, first, recording.columns["displacement"]),
    )


def without_lost_rows(recording: Recording) -> Recording:
    """Return ``recording`` without rows for which no displacement is known: no model predicts their force."""
    moves = np.ones(len(recording), dtype=bool)
    first = np.r_[1.0, np.diff(recording.episode) != 0]
    for before, after in find_gaps(recording.t, first, recording.columns["displacement"]).tolist():
        moves[before + 1 : after] = False
    return recording if moves.all() else recording.select(moves)


def tare_channels(recording: Recording) -> tuple[Recording, dict[str, float]]:
    """Take off the tangential channels what they show in air; return what that was.

    A bias of 5 mN on a pull of 0.8 N is 0.6 % of the friction, several times its standard error.
    """
    air = in_air(recording)
    if np.count_nonzero(air) < LEAST_AIR:
        return recording, {}
    columns = dict(recording.columns)
    tare: dict[str, float] = {}
    for name in ("tangential_force_x", "tangential_force_y", "torque_z"):
        if name in columns and np.any(np.isfinite(columns[name][air])):
            tare[name] = float(np.nanmean(columns[name][air]))
            columns[name] = columns[name] - tare[name]
    return dataclasses.replace(recording, columns=columns), tare


def find_spikes(values: Floats, noise: float, first: Floats) -> Mask:
    """Return single rows far off the line through the two before and the two after: errors, not motion.

    Both lines, because at the turn of a fast stroke a row may be far off its neighbours' mean; and the cubic
    through all four, because at the crest of a fast oscillation it lies far below where both lines meet.
    """
    out = np.zeros(values.size, dtype=bool)
    if values.size < 5:
        return out
    here = values[2:-2]
    before, after = 2.0 * values[1:-3] - values[:-4], 2.0 * values[3:-1] - values[4:]
    cubic = (4.0 * (values[1:-3] + values[3:-1]) - values[:-4] - values[4:]) / 6.0
    off = np.minimum(np.minimum(np.abs(here - before), np.abs(here - after)), np.abs(here - cubic))
    apart = np.abs(values[3:-1] - values[1:-3])
    same = np.maximum.reduce([first[1:-3], first[2:-2], first[3:-1], first[4:]]) == 0.0
    steady = np.abs(before - after) < 0.25 * off  # a ramp, on which neighbours are far apart
    wild = np.where((off > SPIKE * noise) & ((off > 4.0 * apart) | steady) & same, off, 0.0)
    beside = np.maximum(np.r_[0.0, wild[:-1]], np.r_[wild[1:], 0.0])  # whose line goes through the wild row
    out[2:-2] = wild > beside
    return out


def stretches(
    t: Floats, rows: NDArray[np.int64], first: Floats
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut sliding ``rows`` into short stretches; return the row in the middle of each, and its length.

    A slide begins with a stretch of one row, and each is at most as long as all before it: a break-away is
    over in a few rows, and is one event however long the slide is.
    """
    middle, count = [], []
    i = begin = 0
    while i < rows.size:
        if i and (rows[i] > rows[i - 1] + 1 or first[rows[i]] > 0.0):
            begin = i
        longest = min(max(i - begin, 1), LONGEST_STRETCH)
        j = i + 1
        while (
            j < rows.size
            and rows[j] == rows[j - 1] + 1
            and first[rows[j]] == 0.0
            and j - i < longest
            and t[rows[j]] - t[rows[i]] < SLIP_LOAD_WINDOW_S
        ):
            j += 1
        middle.append(int(rows[i]) + (j - i) // 2)
        count.append(j - i)
        i = j
    return np.array(middle, dtype=np.int64), np.array(count, dtype=np.int64)


def _sliding(recording: Recording, noise: Noise) -> NDArray[np.int64]:
    """Return rows that slide under a normal force.

    Not those that show a load: where the noise is a third of the load, they would be the rows whose noise
    adds to it, and friction a quarter too high.
    """
    columns = recording.columns
    pressed = columns["normal_force"] > 5.0 * noise.normal_force
    if not LOADS_AT_SLIP & set(columns):
        return np.zeros(0, dtype=np.int64)
    slips = columns.get("slip", np.zeros(len(recording))) == 1.0
    slips &= ~_creeping(recording, slips)
    known = np.logical_and.reduce([np.isfinite(columns[name]) for name in LOADS_AT_SLIP & set(columns)])
    return np.flatnonzero(slips & pressed & known)


def _creeping(recording: Recording, slips: Mask) -> Mask:
    """Return the rows after slip was felt and before the whole contact slides, whose load is no limit.

    Where a recording has the speed of slides, it is nothing there.
    """
    speed = np.nan_to_num(recording.columns.get("slip_speed", np.zeros(len(recording))))
    if not np.any(slips & (speed > 0.0)):
        return np.zeros(len(recording), dtype=bool)
    out: Mask = slips & (speed == 0.0)
    out[1:] &= out[:-1].copy()
    out[0] = False
    return out


def _seen(recording: Recording, noise: Noise) -> NDArray[np.int64]:
    radius = recording.columns.get("contact_radius")
    if radius is None or not noise.contact_radius > 0.0:
        return np.zeros(0, dtype=np.int64)
    # without a force, a surface that is still dented may or may not count as contact
    pressed = recording.columns["normal_force"] > 5.0 * noise.normal_force
    return np.flatnonzero(np.isfinite(radius) & (radius > 5.0 * noise.contact_radius) & pressed)
