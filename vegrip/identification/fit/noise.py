"""The noise of the sensors of a recording: as stated, checked on replicates or in air, else from signals.

Noise that is white stands out in differences of neighbouring samples, where motion and contact hardly show:
the third difference of white noise has the variance ``20 sigma^2``.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.identification.fit.whitening import ForceNoise
from vegrip.identification.recording import Recording
from vegrip.identification.recording.channels import noise_name
from vegrip.types import Floats

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

MIN_SLOW_GAIN_NATS = 8.0  # [nats] that the slow part has to gain
LOG_LOW, LOG_HIGH = (
    (-5.0, -7.0, -7.0),
    (5.0, 3.0, 7.0),
)  # ln of white and slow over the guess, of the time [s]
MAX_ZERO_NOISES = 100.0  # times the white noise, that a zero may drift or jump by
MAX_ROWS = 40_000  # from which a noise is estimated, to half a percent
START_TIMES_S = (0.3, 1.0, 3.0, 10.0)  # [s] where the search begins
# times the noise that the motions of a pair may differ by (rms), beside a constant, and
MAX_MOTION_NOISES = 1.15
MAX_ROW_NOISES = 7.0  # times in any row; a stiff contact turns 20 um into more than any noise
MIN_PAIR_ROWS = 100
MAX_LENGTH_DIFFERENCE_SAMPLES = 1.5  # [samples] by which the lengths of a pair may differ
LIGHT = 5.0  # noises of the force below which there is no contact
SERVED = ("normal_force", "displacement", "tangential_force_x", "torque_z", "contact_radius")
LEAST_AIR = 100  # rows in air from which their scatter counts
ABOUT = 5  # samples to either side of one that is at rest
STATED = "stated by the recording"
NEIGHBOURS = "differences of neighbouring samples"
SAME_VALUE = 1e-9  # of the range: values that differ by less are the same number, converted
UNDERSTATED, OVERSTATED = 1.2, 1.4  # times that noise is more, or less, than what is stated
LEAST_SCATTER = 200  # rows from which their scatter counts
TRIM = 4.0  # standard deviations beyond which a difference is no noise
APART = 10  # samples over which noise that is not white has changed


@dataclass(frozen=True)
class OuNoise:
    """White std, slow std and its time constant; slow is 0 where it does not pay, or is ``beyond`` noise."""

    white: float
    slow: float
    time: float
    gain: float  # [nats] of the slow part
    beyond: bool = False
    cost: float = math.inf  # [nats] less the logarithm of the likelihood


def estimate_ou_noise(
    t: Floats, first: Floats, y: Floats, X: Floats, rough: float, owner: Floats | None = None
) -> OuNoise:
    """Estimate the noise of ``y`` (n,), NaN where it does not count, beside ``X`` (n, m): white and slow.

        ``y = X b + w + e``,   ``w+ = w exp(-dt / tau) + noise``,   ``e ~ N(0, white^2)``

    an Ornstein-Uhlenbeck process by maximum likelihood, in stretches where nothing else acts: clear of the
    surface, or in the difference of two episodes with the same motion. X holds what is no noise there (a
    constant, a drift, another gain); its coefficients b, of each ``owner`` (n,) of rows, are integrated out
    (restricted likelihood [PattersonThompson1971]_: profiled out, they take a third of the slow part along).
    The slow part counts when the likelihood pays for its two parameters.

    ``first`` is 1 where a stretch begins that does not know of the one before; ``rough``: a guess of the
    white std, same unit as y. Of more than MAX_ROWS rows, stretches spread evenly over those that count are
    taken.
    """
    owner = np.zeros(t.size) if owner is None else owner
    if t.size > MAX_ROWS:
        counted = np.flatnonzero(np.isfinite(y))
        begins = np.diff(np.cumsum(first > 0.0)[counted], prepend=0).astype(np.float64)
        some = spread_rows(begins)
        rows = counted[some]
        t, first, y, X, owner = t[rows], begins[some], y[rows], X[rows], owner[rows]
    ends = np.flatnonzero(np.diff(owner)) + 1
    used = np.isfinite(y).astype(np.float64)
    columns = np.nan_to_num(np.column_stack([y, X]))
    longest = max((t[-1] - t[0]) / 3.0, 1e-9)

    def cost(white: float, slow: float, time: float) -> float:
        errors, total = innovations(t, first, white**2, slow**2, time, used, columns)
        for own in np.split(errors, ends):
            G = own.T @ own
            power = np.diag(G)[1:]
            L = np.linalg.cholesky(G[1:, 1:] + np.diag(np.where(power > 0.0, 1e-12 * power, 1.0)))
            along = np.linalg.solve(L, G[1:, 0])
            total += 0.5 * float(G[0, 0] - along @ along) + float(np.sum(np.log(np.diag(L))))
        return total

    def alone(p: Floats) -> float:
        return cost(rough * float(np.exp(np.clip(p[0], -5.0, 5.0))), 0.0, 2.0)

    def of(p: Floats) -> tuple[float, float, float]:
        a, b, c = np.clip(p, LOG_LOW, LOG_HIGH)
        return rough * float(np.exp(a)), rough * float(np.exp(b)), min(float(np.exp(c)), longest)

    def both(p: Floats) -> float:
        return cost(*of(p))

    plain = _least(alone, np.array([0.0]))
    white = rough * float(np.exp(plain.x[0]))
    starts = [[plain.x[0], -0.7, float(np.log(time))] for time in START_TIMES_S if time < longest]
    if not starts:
        return OuNoise(white, 0.0, 2.0, 0.0, cost=float(plain.fun))
    best = min(starts, key=lambda p: both(np.array(p)))
    found = _least(both, np.array(best))
    gain = float(plain.fun - found.fun)
    if gain < MIN_SLOW_GAIN_NATS:
        return OuNoise(white, 0.0, 2.0, max(gain, 0.0), cost=float(plain.fun))
    if found.x[1] > LOG_HIGH[1] - 0.1:
        return OuNoise(rough, 0.0, 2.0, gain, beyond=True, cost=float(found.fun))
    return OuNoise(*of(found.x), gain, cost=float(found.fun))


def spread_rows(first: Floats, most: int = MAX_ROWS) -> NDArray[np.int64]:
    """Return at most ``most`` rows: whole stretches spread evenly, or the beginnings of a few long ones."""
    starts = np.flatnonzero(first > 0.0)
    lengths = np.diff(np.append(starts, first.size))
    count = min(starts.size, max(4, most * starts.size // first.size))
    chosen = np.linspace(0, starts.size - 1, count).round().astype(int)
    each = np.minimum(lengths[chosen], most // count)
    return np.concatenate([np.arange(starts[i], starts[i] + n) for i, n in zip(chosen, each, strict=True)])


@njit
def innovations(
    t: Floats, first: Floats, white: float, slow: float, time: float, used: Floats, columns: Floats
) -> tuple[Floats, float]:
    """Return the one-step prediction errors of ``columns`` (n, m) over their std, and the sum of ln std.

    ``white`` and ``slow`` are variances; the recursion of :mod:`vegrip.identification.fit.whitening` for a
    tip that rests.
    """
    n, m = columns.shape
    out, x = np.zeros((n, m)), np.zeros(m)
    scale, P = 0.0, slow
    for i in range(n):
        if first[i] > 0.0:
            x[:] = 0.0
            P = slow
        else:
            kept = np.exp(-(t[i] - t[i - 1]) / time)
            x *= kept
            P = kept * kept * P + slow * (1.0 - kept * kept)
        if used[i] > 0.0:
            S = P + white
            scale += 0.5 * np.log(S)
            for c in range(m):
                v = columns[i, c] - x[c]
                x[c] += P / S * v
                out[i, c] = v / np.sqrt(S)
            P -= P * P / S
    return out, scale


def _least(cost: Callable[[Floats], float], start: Floats) -> "OptimizeResult":
    """Minimise by simplex; its first steps given, because scipy's are relative and one start is ln 1 = 0."""
    from scipy.optimize import minimize  # noqa: PLC0415 (slow to import, which the virtual hand would pay)

    simplex = np.vstack([start, *(start + 0.3 * row for row in np.eye(start.size))])
    options: Any = {"xatol": 1e-2, "fatol": 1e-2, "initial_simplex": simplex}
    return minimize(cost, start, method="Nelder-Mead", options=options)


@dataclass(frozen=True)
class Pair:
    """Rows of two episodes with the same motion. What they differ by is noise, whatever the model lacks."""

    one: np.ndarray
    other: np.ndarray


def find_copies(recording: Recording) -> dict[int, int]:
    """Return the episodes that repeat an earlier one to the last bit, and which: no sensor does that."""
    seen: dict[bytes, int] = {}
    copies = {}
    for number in dict.fromkeys(recording.episode.tolist()):
        rows = recording.episode == number
        first = seen.setdefault(b"".join(one[rows].tobytes() for one in recording.columns.values()), number)
        if first != number and any(np.ptp(one[rows]) > 0.0 for one in recording.columns.values()):
            copies[number] = first
    return copies


def find_pairs(recording: Recording, noise: float) -> list[Pair]:
    """Return the pairs of episodes whose displacement agrees to ``noise`` [m], each episode in one pair.

    A copy of an episode is no second measurement of it.
    """
    depth, copies = recording.columns["displacement"], find_copies(recording)
    rows = [
        np.flatnonzero(recording.episode == number)
        for number in dict.fromkeys(recording.episode.tolist())
        if number not in copies
    ]
    rows = [one for one in rows if one.size >= MIN_PAIR_ROWS and np.isfinite(depth[one]).all()]
    found: list[Pair] = []
    free = list(range(len(rows)))
    while free:
        i = free.pop(0)
        for j in free:
            if _is_same(recording.t, depth, rows[i], rows[j], noise):
                n = min(rows[i].size, rows[j].size)
                found.append(Pair(rows[i][:n], rows[j][:n]))
                free.remove(j)
                break
    return found


def _is_same(t: Floats, depth: Floats, one: np.ndarray, other: np.ndarray, noise: float) -> bool:
    if abs(one.size - other.size) > MAX_LENGTH_DIFFERENCE_SAMPLES:
        return False
    n = min(one.size, other.size)
    a, b = one[:n], other[:n]
    step = float(np.median(np.diff(t[a])))
    if np.abs((t[a] - t[a[0]]) - (t[b] - t[b[0]])).max() > 0.1 * step:
        return False
    apart = depth[a] - depth[b]
    moved = depth[a].max() - depth[a].min()
    both = np.sqrt(2.0) * noise
    off = np.abs(apart - apart.mean())
    return bool(
        np.std(apart) < MAX_MOTION_NOISES * both
        and off.max() < MAX_ROW_NOISES * both
        and moved > 20.0 * noise
    )


def noise_of_pairs(recording: Recording, found: list[Pair], white: float) -> OuNoise:
    """Return the noise of one force sensor from the differences of pairs; ``white`` [N] is a guess.

    Beside a constant, a pair may differ by a gain and by a shift of the surface (its stiffness goes about as
    the cube root of the force): what a first press changes for the second is an effect, no noise.
    """
    force = recording.columns["normal_force"]
    found = _some(found)
    times, first, y, columns = [], [], [], []
    begin = 0.0
    for pair in found:
        t = recording.t[pair.one]
        times.append(t - t[0] + begin)
        begin = times[-1][-1] + 1e3
        first.append(np.r_[1.0, np.zeros(t.size - 1)])
        y.append((force[pair.one] - force[pair.other]) / np.sqrt(2.0))
        columns.append(np.column_stack(list(_beside(0.5 * (force[pair.one] + force[pair.other]), white))))
    owner = np.repeat(np.arange(float(len(found))), [one.size for one in y])
    t, begins, apart, X = (np.concatenate(one) for one in (times, first, y, columns))
    return estimate_ou_noise(t, begins, apart, X, white, owner)


def _some(found: list[Pair]) -> list[Pair]:
    """Return pairs spread evenly over all, of no more than MAX_ROWS rows where there are several."""
    rows = sum(pair.one.size for pair in found)
    count = max(1, min(len(found), MAX_ROWS * len(found) // max(rows, 1)))
    return [found[i] for i in np.linspace(0, len(found) - 1, count).round().astype(int)]


def _beside(force: Floats, white: float) -> Iterator[Floats]:
    pressed = np.where(np.nan_to_num(force) > LIGHT * white, np.nan_to_num(force), 0.0)
    yield np.ones(force.size)
    yield pressed
    yield np.cbrt(pressed)


@dataclass(frozen=True)
class Noise:
    """Standard deviations, SI; ``source`` says of each where it comes from, ``doubts`` what disagrees."""

    normal_force: float
    displacement: float
    tangential_force: float = math.nan
    torque_z: float = math.nan
    contact_radius: float = math.nan
    slow_force: float = 0.0  # [N] wandering of the force sensor
    slow_time: float = 2.0  # [s] its time constant
    tolerance: float = 0.0  # share of an episode's peak force by which a model may be wrong
    source: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()

    def of_force(self, force: Floats, episode: np.ndarray) -> ForceNoise:
        """Return what the whitening needs for the measured ``force`` (n,) [N]; NaN counts as none."""
        peaks = np.zeros(int(episode.max()) + 1)
        np.maximum.at(peaks, episode, np.abs(np.nan_to_num(force)))
        white = np.hypot(self.normal_force, self.tolerance * peaks[episode])
        return ForceNoise(white, self.slow_force, self.slow_time)

    def tolerant(self, tolerance: float) -> "Noise":
        """Return the same noise, for a model that may be wrong by ``tolerance`` of the peak force."""
        return dataclasses.replace(self, tolerance=tolerance)


def noise_of(recording: Recording) -> Noise:
    """Return the noise of ``recording``: as it is stated, else from differences of neighbouring samples.

    The force is checked, and its slow wandering found, where nothing but noise acts: in the differences of
    replicate episodes if there are some, else at rest in air.
    """
    values: dict[str, float] = {}
    source: dict[str, str] = {}
    for channel in SERVED:
        if channel not in recording.columns or (recording.is_step and channel == "displacement"):
            continue  # a step is exact, or its noise is that of the force
        name, column = noise_name(channel), recording.columns[channel]
        stated = recording.sensors.get(name, math.nan)
        if stated > 0.0:
            values[name], source[name] = stated, STATED
        else:
            values[name], source[name] = rough(column, recording.episode), NEIGHBOURS
    doubts = list(_contradicted(recording, values, source))
    doubts += [
        f"episode {number} is a copy of episode {first}, to the last bit: it is counted twice"
        for number, first in find_copies(recording).items()
    ]
    found, where = _seen(recording, values)
    if found is not None:
        white = max(found.white, rounding(recording.columns["normal_force"]))
        ratio = white / values["normal_force"]
        if source["normal_force"] == NEIGHBOURS or not 1.0 / OVERSTATED < ratio < UNDERSTATED:
            if source["normal_force"] == STATED:
                doubts.append(
                    f"the force scatters by {white:.3g} N ({where}), but its noise is stated as "
                    f"{values['normal_force']:.3g} N; the measured one is used"
                )
            values["normal_force"], source["normal_force"] = white, where
        source["slow_force"] = where if found.slow > 0.0 else f"none seen ({where})"
        if found.beyond:
            source["slow_force"] = "not believed"
            doubts.append(
                f"the force wanders by far more than noise ({where}): a zero that shifts, or what is left of "
                "a contact; it is not counted as noise"
            )
    return Noise(
        values.get("normal_force", math.nan),
        values.get("displacement", 0.0),
        values.get("tangential_force", math.nan),
        values.get("torque_z", math.nan),
        values.get("contact_radius", math.nan),
        found.slow if found is not None else 0.0,
        found.time if found is not None else 2.0,
        source=source,
        doubts=tuple(doubts),
    )


def _contradicted(recording: Recording, values: dict[str, float], source: dict[str, str]) -> Iterator[str]:
    """Put what is seen at rest in the place of noise that is stated as another; yield what was stated.

    The force is seen better by :func:`_seen`.
    """
    if not {"normal_force", "displacement"} <= values.keys():
        return
    rest = at_rest(recording, np.ones(len(recording), dtype=bool), values["displacement"])
    for channel in SERVED[1:]:
        name, column = noise_name(channel), recording.columns.get(channel)
        if column is None or source[name] != STATED:
            continue
        where, rows = "at rest", rest
        if channel == "contact_radius":
            rows = rest & (column > 5.0 * values[name])
        elif channel != "displacement":
            where, rows = "in air", in_air(recording)
        least, most = scatter(column, recording.episode, rows)
        found = min(max(values[name], least), most)
        if not 1.0 / OVERSTATED < found / values[name] < UNDERSTATED:
            yield (
                f"{channel} scatters by {found:.3g} {where}, but its noise is stated as {values[name]:.3g}; "
                "the measured one is used"
            )
            values[name], source[name] = found, f"scatter {where}"


def scatter(values: Floats, episode: Floats | np.ndarray, rows: np.ndarray) -> tuple[float, float]:
    """Return the least and the largest std that the noise of ``values`` (n,) may have, seen in ``rows``.

    The least is that of third differences, which filtered noise has too little of; the largest is that of
    what lies ten samples apart, which has slow motion in it. 0 and inf where the rows are few.
    """
    found = [rounding(values)]
    for weights in ([1.0, -3.0, 3.0, -1.0], [1.0, *[0.0] * (APART - 1), -1.0]):
        n = len(weights) - 1
        jumps = np.convolve(values, weights, "valid")
        same = np.asarray(episode[n:] == episode[:-n]) & rows[n:] & rows[:-n] & np.isfinite(jumps)
        if np.count_nonzero(same) < LEAST_SCATTER:
            return 0.0, math.inf
        size = np.abs(jumps[same])
        near = size[size <= TRIM / 0.6745 * max(float(np.median(size)), found[0])]
        found.append(float(np.sqrt(np.mean(near**2) / np.sum(np.square(weights)))))
    return max(found[:2]), max(found)


def _seen(recording: Recording, known: Mapping[str, float]) -> tuple[OuNoise | None, str]:
    if not {"normal_force", "displacement"} <= set(known):
        return None, ""
    white = known["normal_force"]
    if not white > 0.0:
        return None, ""
    same = find_pairs(recording, known["displacement"])
    if same:
        plural = "s" if len(same) > 1 else ""
        return noise_of_pairs(recording, same, white), f"{len(same)} pair{plural} of replicate episodes"
    air = in_air(recording)
    rest = at_rest(recording, air, known["displacement"])
    if np.count_nonzero(rest) < LEAST_AIR:
        if np.count_nonzero(air) < LEAST_AIR:
            return None, ""
        scatter = rough(recording.columns["normal_force"][air], recording.episode[air])
        return OuNoise(scatter, 0.0, 2.0, 0.0), "scatter in air"
    t = recording.t
    y = np.where(rest, recording.columns["normal_force"], np.nan)
    first = np.r_[1.0, np.zeros(t.size - 1)]
    guess = rough(recording.columns["normal_force"][rest], recording.episode[rest])
    return estimate_wandering(t, first, y, guess), "scatter in air"


def estimate_wandering(t: Floats, first: Floats, y: Floats, rough: float) -> OuNoise:
    """Estimate the noise as :func:`estimate_ou_noise` beside a constant and a drift, a step of it, or both.

    A zero that jumps once would pass for wandering, which then hides it. Each pays for its size, and the step
    for the choice of its place, the one that leaves the least squares.
    """
    constant, drift = np.ones(t.size), rough * (t - t.mean()) / max(t[-1] - t[0], 1e-300)
    best = estimate_ou_noise(t, first, y, np.column_stack([constant, drift]), rough)
    rows = np.flatnonzero(np.isfinite(y))
    if not (best.slow or best.beyond) or rows.size <= 2 * (LEAST_AIR // 2):  # too few on both sides of a step
        return best
    cost = best.cost
    for beside in ([constant], [constant, drift]):
        at = _step(y[rows], np.column_stack(beside)[rows])
        step = np.where(np.arange(t.size) >= rows[at], rough, 0.0)
        one = estimate_ou_noise(t, first, y, np.column_stack([*beside, step]), rough)
        pays = math.log(rows.size) + (len(beside) - 1) * math.log(MAX_ZERO_NOISES)
        if one.cost + pays < cost:
            best, cost = one, one.cost + pays
    return best


def _step(y: Floats, X: Floats) -> int:
    """Return the row from which on a step beside ``X`` leaves the least squares of ``y``."""
    basis, _ = np.linalg.qr(X)
    r = y - basis @ (basis.T @ y)

    def later(values: Floats) -> Floats:
        return np.cumsum(values[::-1], axis=0)[::-1]

    power = np.arange(y.size, 0, -1.0) - np.sum(later(basis) ** 2, axis=1)
    inside = slice(LEAST_AIR // 2, -(LEAST_AIR // 2))
    return LEAST_AIR // 2 + int(np.argmax((later(r) ** 2 / np.maximum(power, 1.0))[inside]))


def at_rest(recording: Recording, rows: np.ndarray, noise: float) -> np.ndarray:
    """Return those of ``rows`` (n,) about which the displacement stays within its ``noise`` [m]."""
    depth = recording.columns["displacement"]
    n = depth.size
    out = np.zeros(n, dtype=bool)
    middle = slice(ABOUT, n - ABOUT)
    moved = np.abs(depth[2 * ABOUT :] - depth[: -2 * ABOUT])
    same = recording.episode[2 * ABOUT :] == recording.episode[: -2 * ABOUT]
    calm = rows[middle] & rows[2 * ABOUT :] & rows[: -2 * ABOUT]
    out[middle] = calm & same & (moved <= 6.0 * noise)
    return out


def rough(values: Floats, episode: Floats | np.ndarray) -> float:
    """Return the std of the white part of ``values`` (n,), at least what rounding to their steps leaves."""
    jumps = np.diff(values, 3)[np.asarray(episode[3:] == episode[:-3])]
    jumps = jumps[np.isfinite(jumps)]
    if jumps.size < 8:
        return math.nan
    middle = float(np.median(np.abs(jumps))) / 0.6745 / math.sqrt(20.0)
    return max(middle, rounding(values), 1e-12)


def rounding(values: Floats) -> float:
    """Return the std of what rounding to the smallest step of ``values`` leaves, 0 where there is no step."""
    known = np.unique(values[np.isfinite(values)])
    steps = np.diff(known)
    steps = steps[steps > SAME_VALUE * np.ptp(known)] if steps.size else steps
    return float(steps.min()) / math.sqrt(12.0) if steps.size else 0.0


def in_air(recording: Recording) -> np.ndarray:
    """Return the rows (n,) in which the tip is clear of the surface, as far as the displacement shows."""
    depth = recording.columns.get("displacement")
    if depth is None:
        return np.zeros(len(recording), dtype=bool)
    clear = 5.0 * recording.sensors.get("displacement", 0.0)
    if np.isfinite(recording.fingertip.radius):
        clear = max(clear, 2e-3 * recording.fingertip.radius)
    return np.asarray(depth < -clear)
