"""Replicates: episodes with the same motion. What they differ by is noise, whatever the model lacks."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vegrip.identification.fit.ou_noise import MAX_ROWS, OuNoise, estimate_ou_noise
from vegrip.identification.recording import Recording
from vegrip.types import Floats

MAX_MOTION_NOISES = (
    1.15  # times the noise that the motions of a pair may differ by (rms), beside a constant, and
)
MAX_ROW_NOISES = 7.0  # times in any row; a stiff contact turns 20 um into more than any noise
MIN_PAIR_ROWS = 100
MAX_LENGTH_DIFFERENCE_SAMPLES = 1.5  # [samples] by which the lengths of a pair may differ
LIGHT = 5.0  # noises of the force below which there is no contact


@dataclass(frozen=True)
class Pair:
    """Two episodes with the same motion: their rows."""

    one: np.ndarray
    other: np.ndarray


def find_pairs(recording: Recording, noise: float) -> list[Pair]:
    """Return the pairs of episodes whose displacement agrees to ``noise`` [m], each episode in one pair."""
    depth = recording.columns["displacement"]
    rows = [
        np.flatnonzero(recording.episode == number) for number in dict.fromkeys(recording.episode.tolist())
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
    m = columns[0].shape[1]
    X = np.zeros((sum(one.size for one in y), m * len(found)))
    row = 0
    for i, block in enumerate(columns):
        X[row : row + len(block), m * i : m * (i + 1)] = block
        row += len(block)
    X = X[:, np.any(X != 0.0, axis=0)]
    return estimate_ou_noise(np.concatenate(times), np.concatenate(first), np.concatenate(y), X, white)


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
