"""Doubts about the recording itself, which come before any effect is named.

Some faults of a recording look like physics: clocks that disagree like a lag, a wrong radius like another law
of the radius. Others leave too little to say anything. Each is reported in a sentence; a grave one forbids
names.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vegrip.effects import effect
from vegrip.errors import RecordingError
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.candidate_fit import EVALUATIONS, CandidateFit
from vegrip.identification.fit.preprocess import Measured
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import refine_optimum
from vegrip.identification.recording import Recording
from vegrip.identification.recording.checks import suspect_columns
from vegrip.identification.recording.report import MISSING, describe_missing
from vegrip.types import Floats

TIP_RADIUS = -3  # in the model's vector


@dataclass(frozen=True)
class Doubt:
    """A sentence, and whether nothing may be named because of it."""

    text: str
    is_grave: bool = False


def refuse_unusable(recording: Recording, measured: Measured) -> None:
    """Refuse a recording from which nothing can be concluded.

    Raises:
        RecordingError: nothing touches, or the force never changes; says what.

    """
    force = measured.force[np.isfinite(measured.force)]
    floor = float(np.median(force[: max(force.size // 10, 1)]))
    span = float(np.quantile(force, 0.999) - np.quantile(force, 0.001))
    if span < 8.0 * measured.noise.normal_force:
        raise RecordingError(
            f"{recording.name} is without contact: the normal force stays within its noise "
            f"({floor:.3g} N, +-{measured.noise.normal_force:.2g} N)"
        )


def check_before_search(problem: Problem) -> Iterator[Doubt]:
    """Yield what is wrong with a recording before anything is looked for."""
    m = problem.measured
    t = m.recording.t
    touching = problem.stiffness > 0.0
    if not touching.any() and not m.recording.is_step:
        columns, radius = m.recording.columns, m.recording.fingertip.radius
        suspected = next(suspect_columns(m.recording.episode, columns, radius), "")
        raise RecordingError(
            f"{m.recording.name}: the model never touches in this recording, and no effect can show: "
            f"{suspected or 'look at the zeros and signs of displacement and force, --zero and --negate'}"
        )
    step = float(np.median(np.diff(t)))
    lasted = float(np.count_nonzero(touching)) * step
    if np.count_nonzero(touching) < thresholds.MIN_CONTACT_ROWS or lasted < thresholds.BRIEF_CONTACT_S:
        yield Doubt(
            f"only {lasted:.2g} s ({np.count_nonzero(touching)} rows) are in contact: "
            "too little to distinguish effects",
            is_grave=True,
        )
    if m.recording.is_step:  # which moves once, and has neither tip nor clocks
        return
    missing = m.recording.source.get(MISSING)
    if isinstance(missing, int) and missing > 0:
        yield Doubt(describe_missing(missing))
    for sentence in suspect_columns(m.recording.episode, m.recording.columns, m.recording.fingertip.radius):
        yield Doubt(sentence, is_grave=True)
    deepest = float(np.nanmax(m.motion.displacement))
    if deepest > thresholds.MAX_DEPTH_RADII * problem.model.tip_radius:
        yield Doubt(
            f"the deepest indentation is {1e3 * deepest:.3g} mm, the radius of the tip is stated as "
            f"{1e3 * problem.model.tip_radius:.3g} mm: radius or unit of the displacement is wrong",
            is_grave=True,
        )
    for rows in _still(m):
        force = m.force[rows]
        rise = float(np.nanmax(force - np.fmin.accumulate(force)))
        if rise > thresholds.MIN_STILL_RISE * float(np.nanmax(np.abs(m.force))):
            lasted = t[rows.stop - 1] - t[rows.start]
            yield Doubt(
                f"the force rises by {rise:.3g} N within {lasted:.3g} s of one displacement: "
                "its sensor stands still; record the motion again",
                is_grave=True,
            )
            break
    late = shift(t, m.first, m.motion.displacement, m.force)
    if abs(late) > max(thresholds.MIN_VISIBLE_SHIFT_S, thresholds.MIN_VISIBLE_SHIFT_SAMPLES * step):
        is_grave = abs(late) > thresholds.MAX_SENSOR_LAG_S
        cause = (
            "their clocks disagree; shift one of them"
            if is_grave
            else "a slow sensor, or their clocks disagree"
        )
        order = "after" if late > 0.0 else "before"
        yield Doubt(
            f"the force changes {abs(1e3 * late):.0f} ms {order} the displacement: {cause}", is_grave=is_grave
        )


def _still(m: Measured) -> Iterator[slice]:
    """Yield long runs of rows of an episode that have one displacement."""
    moves = (np.diff(m.motion.displacement) != 0.0) | (m.first[1:] > 0.5)
    ends = [0, *np.flatnonzero(moves) + 1, m.first.size]
    for begin, end in itertools.pairwise(ends):
        if end - begin >= thresholds.STILL_ROWS:
            yield slice(begin, end)


def shift(t: Floats, first: Floats, displacement: Floats, force: Floats) -> float:
    """Return by how much the force follows the displacement [s]: the lag at which their rates agree best.

    0 where they agree at none.
    """
    step = float(np.median(np.diff(t)))
    same = (first[1:] == 0.0) & (np.diff(t) < 3.0 * step)
    quick = np.where(same, np.diff(displacement), 0.0)
    push = np.where(same & np.isfinite(np.diff(force)), np.diff(np.nan_to_num(force)), 0.0)
    quick[displacement[1:] <= 0.0] = 0.0
    most = min(int(thresholds.MAX_CLOCK_SHIFT_S / step), quick.size // 4)
    if not quick.any() or not push.any():
        return 0.0
    size = 2 ** math.ceil(math.log2(2 * quick.size))
    crossed = np.fft.irfft(np.fft.rfft(push, size) * np.conj(np.fft.rfft(quick, size)), size)
    lags = np.r_[np.arange(most + 1), np.arange(-most, 0)]
    best = int(lags[np.argmax(crossed[lags])])
    if crossed[best] < thresholds.MIN_RATE_CORRELATION * math.sqrt(float(push @ push) * float(quick @ quick)):
        return 0.0
    return best * step


class Shifted(Problem):
    """The problem with one unknown more, the last: by how much [s] the clock of the force is late."""

    def __init__(self, base: Problem) -> None:
        self.__dict__.update(base.__dict__)  # the same rows, noise and compiled model
        limit = thresholds.MAX_CLOCK_SHIFT_S
        self.unknowns = base.unknowns.with_one("clock", -limit, limit, thresholds.MAX_SENSOR_LAG_S)
        t, first = base.measured.recording.t, base.measured.first
        self._apart = t + 10.0 * limit * np.cumsum(first)  # episodes do not know of each other

    def parts(self, u: Floats) -> tuple[Floats, tuple[Floats, Floats]]:
        """Return the model's vector and the zeros (n,), that of the displacement with what it moves."""
        vector, (displacement, force) = super().parts(u)
        motion = self.measured.motion.displacement
        return vector, (displacement + motion - np.interp(self._apart - u[-1], self._apart, motion), force)


class Remeasured(Problem):
    """The problem with one unknown more, the last: ln of the tip's radius over the stated one."""

    def __init__(self, base: Problem) -> None:
        self.__dict__.update(base.__dict__)
        limit = math.log1p(thresholds.RADIUS_TOLERANCE)
        self.unknowns = base.unknowns.with_one("radius", -limit, limit, limit)

    def parts(self, u: Floats) -> tuple[Floats, tuple[Floats, Floats]]:
        """Return the model's vector, with that radius, and the zeros (n,)."""
        vector, zeros = super().parts(u)
        vector[TIP_RADIUS] *= math.exp(u[-1])
        return vector, zeros


def other_radius(base: CandidateFit) -> tuple[float, float]:
    """Return the radius of the tip near the stated one that explains most [m], and its gain [nats]."""
    problem = Remeasured(base.problem)
    best = refine_optimum(problem, np.append(base.optimum.u, 0.0), EVALUATIONS)
    return problem.model.tip_radius * math.exp(float(best.u[-1])), base.optimum.cost - best.cost


def apart(base: CandidateFit) -> tuple[float, float]:
    """Return the shift of the force's clock that explains most of the misfit [s], and its gain [nats].

    From no shift, and from that at which the rates agree best.
    """
    m = base.problem.measured
    if m.recording.is_step:
        return 0.0, 0.0
    late = shift(m.recording.t, m.first, m.motion.displacement, m.force)
    problem = Shifted(base.problem)
    starts = [np.append(base.optimum.u, value) for value in {0.0, late}]
    fits = [refine_optimum(problem, start, EVALUATIONS) for start in starts]
    best = min(fits, key=lambda one: one.cost)
    return float(best.u[-1]), base.optimum.cost - best.cost


def check_clocks(base: CandidateFit, best: float) -> list[Doubt]:
    """Return the doubt that clocks disagree, if that explains more than the ``best`` effect [nats].

    A force that is late may have a slow sensor, which has to be beaten by far; an early one can have none.
    """
    late, gain = apart(base)
    share = thresholds.SHIFT_ADVANTAGE_SHARE if late > 0.0 else thresholds.INDISTINGUISHABLE_SHARE
    if gain < thresholds.MIN_SHIFT_NATS + (1.0 + share) * max(best, 0.0):
        return []
    return [
        Doubt(
            f"a force that is {abs(1e3 * late):.2g} ms {'late' if late > 0.0 else 'early'} explains more "
            "than any effect: the clocks of force and displacement disagree",
            is_grave=True,
        )
    ]


def check_lookalikes(names: list[str], values: dict[str, float], radius: float) -> list[Doubt]:
    sentences = [effect(name).imitated_by for name in names]
    return [Doubt(sentence.format(**values | {"radius": radius})) for sentence in sentences if sentence]
