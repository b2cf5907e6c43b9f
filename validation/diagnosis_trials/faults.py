"""What is wrong with a recording in use, which no effect of the pad is to be blamed for."""

from dataclasses import dataclass, fields, replace

import numpy as np

from vegrip.identification.recording import Fingertip, Recording
from vegrip.virtual.bench.protocol import Episode

STAMP_JITTER_S = 5e-4  # [s] std of the error of a time stamp
GAP_EVERY_S = 4.0  # [s] of recording for each gap, on average
GAPS_S = (0.03, 0.4)  # [s] from the shortest to the longest
FORCE_SHIFT_NOISES = 8.0  # of the force
DEPTH_SHIFT_SHARE = 0.03  # of the deepest press
SHIFT_BETWEEN = (0.25, 0.75)  # of the rows


@dataclass(frozen=True)
class Faults:
    """What is wrong with a recording.

    Attributes:
        noise_stated: the noise of every sensor as it is stated, over what it is.
        radius_stated: the same of the fingertip's radius.
        jitter: rows are taken at uneven instants, up to a quarter of the period early or late, and stamped
            with an error.
        gaps: rows are lost, a few hundredths to tenths of a second at a time.
        in_contact: begins when the first press has reached its depth.
        zero_shift: the zero of force or displacement jumps at one moment.

    """

    noise_stated: float = 1.0
    radius_stated: float = 1.0
    jitter: bool = False
    gaps: bool = False
    in_contact: bool = False
    zero_shift: bool = False

    def __str__(self) -> str:
        told = [(one.name, getattr(self, one.name)) for one in fields(self)]
        unlike = [(name, value) for name, value in told if value != getattr(Faults, name)]
        return " ".join(name if value is True else f"{name} {value:g}" for name, value in unlike)

    @property
    def leave_misfit(self) -> bool:
        """Whether no model with one radius and one zero explains such a recording."""
        return self.zero_shift or self.radius_stated != 1.0

    def spoil(self, made: Recording, first: Episode, depth: float, seed: int) -> Recording:
        """Return ``made`` with these faults but the jitter; ``depth`` [m] is the deepest press."""
        rng = np.random.default_rng([seed, 23])
        out = self._misstated(self._shifted(made, depth, rng) if self.zero_shift else made)
        keep = np.ones(len(out), dtype=bool)
        if self.gaps:
            seconds = float(np.median(np.diff(out.t))) * len(out)
            begin = rng.choice(out.t, size=max(1, round(seconds / GAP_EVERY_S)), replace=False)
            for at, length in zip(begin, rng.uniform(*GAPS_S, begin.size), strict=True):
                keep &= (out.t < at) | (out.t > at + length)
        if self.in_contact:
            keep &= out.t > _reached(first)
        return out if keep.all() else out.select(keep)

    def _misstated(self, made: Recording) -> Recording:
        stated = {name: self.noise_stated * value for name, value in made.sensors.items()}
        return replace(made, sensors=stated, fingertip=Fingertip(self.radius_stated * made.fingertip.radius))

    def _shifted(self, made: Recording, depth: float, rng: np.random.Generator) -> Recording:
        name = str(rng.choice(["normal_force", "displacement"]))
        sizes = {
            "normal_force": FORCE_SHIFT_NOISES * made.sensors["normal_force"],
            "displacement": DEPTH_SHIFT_SHARE * depth,
        }
        later = np.arange(len(made)) >= int(rng.uniform(*SHIFT_BETWEEN) * len(made))
        size = float(rng.choice([-1.0, 1.0])) * sizes[name]
        return replace(made, columns={**made.columns, name: made.columns[name] + size * later})


NO_FAULTS = Faults()


def _reached(episode: Episode) -> float:
    """Return when the first press of an episode has reached its depth or force [s]."""
    passed = 0.0
    for segment in episode:
        passed += segment.duration
        if (segment.depth or 0.0) > 0.0 or (segment.force or 0.0) > 0.0:
            break
    return passed


def uneven_rows(count: int, every: int, seed: int) -> np.ndarray:
    """Return the numbers of one row in ``every``, each up to a quarter of that early or late."""
    rows = np.arange(every - 1, count - every, every)
    early, late = every // 4, max(every // 4, 1)
    return rows + np.random.default_rng([seed, 29]).integers(-early, late + 1, rows.size)
