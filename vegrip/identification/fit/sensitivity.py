"""How an error of the motion changes the modelled force: by position, by speed, and across a backlash.

The error of a smoothed motion reaches the force by three ways:

* by position, times the stiffness;
* by speed, where a model has drag or damping, and the more where the motion bends: when between two samples
  it does is not known;
* behind backlash, where the tip rests until the gap is crossed, it stays what it was when the tip last moved.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.identification.fit.motion import Motion
from vegrip.model import BASE, ContactModel
from vegrip.types import Floats

MIN_PLAY_STDS = 1.0  # standard deviations of the displacement, below which a play is none
SHAKE_STDS = 1e-4  # of them, by which a motion is shaken to see whether the tip follows
RESTING_SHARE = 1e-3  # of the shaking, below which it does not

Answer = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """What an error of the motion makes of the force.

    Attributes:
        position: (n,) [N/m]; 0 in air.
        speed: (n,) [N s/m].
        follows: (n,) whether the tip moves with the drive; where not, the error of its position stays.
        bend: (n,) [N] std of what is not known because the motion bends between samples.

    """

    position: Floats
    speed: Floats
    follows: NDArray[np.bool_]
    bend: Floats


def by_position(stiffness: Floats) -> Sensitivity:
    """Return the sensitivity (n,) of a force without effect of speed or backlash; ``stiffness`` [N/m]."""
    none = np.zeros(stiffness.size)
    return Sensitivity(stiffness, none, np.ones(stiffness.size, dtype=bool), none)


def feels_speed(model: ContactModel) -> bool:
    """Whether an effect that was added takes the speed."""
    return any(
        "speed" in _arguments(h.function) for e in model.effects if e.name not in BASE for h in e.hooks
    )


def has_play(model: ContactModel) -> bool:
    """Whether something between drive and tip remembers."""
    return any(e.states and h.stage == "tip" for e in model.effects for h in e.hooks)


def _arguments(function: object) -> tuple[str, ...]:
    code = getattr(function, "__code__", None)
    return tuple(code.co_varnames[: code.co_argcount]) if code is not None else ()


def follows(indentation: Answer, first: Floats, motion: Floats, noise: float) -> NDArray[np.bool_]:
    """Return whether the tip follows each step (n,) of a motion that is shaken a little.

    ``indentation`` of the tip [m], by what is added to the ``motion`` (n,) [m]. A tip that is never farther
    from where the motion takes it than the ``noise`` [m] has no play that could be told.
    """
    still = indentation(np.zeros(first.size))
    away = (still - motion)[still > 0.0]
    if not away.size or np.ptp(away) < 2.0 * MIN_PLAY_STDS * noise:
        return np.ones(first.size, dtype=bool)
    shake = SHAKE_STDS * noise * np.random.default_rng(0).standard_normal(first.size)
    moved = indentation(shake) - still
    rests = np.abs(np.diff(moved)) < RESTING_SHARE * np.abs(np.diff(shake))
    out: NDArray[np.bool_] = np.r_[True, ~rests | (first[1:] > 0.5)]
    return out


def by_speed(force: Answer, t: Floats, first: Floats, motion: Motion) -> tuple[Floats, Floats]:
    """Return what the error of the speed does (n,) [N s/m], and the std of what a bend hides (n,) [N].

    ``force`` [N] by the speed (n,) [m/s]. The slope is that over the standard error of the speed, as wide as
    the force is bent within it.
    """
    steps = np.diff(motion.displacement) / np.diff(t)
    jump = first[1:] > 0.5
    steps[jump] = 0.0
    before, after = np.r_[0.0, steps], np.r_[steps, 0.0]
    before[first > 0.5] = after[first > 0.5]
    ends = np.r_[jump, True]
    after[ends] = before[ends]
    std = np.maximum(speed_std(t, first, motion.pull, motion.push, motion.start), 1e-12)
    middle = 0.5 * (before + after)
    slope = (force(middle + std) - force(middle - std)) / (2.0 * std)
    return slope, np.abs(force(after) - force(before)) / np.sqrt(12.0)


@njit
def speed_std(t: Floats, first: Floats, pull: Floats, push: Floats, start: Floats) -> Floats:
    """Return the standard error (n,) [m/s] of the smoothed speed after each sample."""
    n = t.shape[0]
    out = np.zeros(n)
    dd, dv, vv = 0.0, 0.0, 0.0
    for i in range(n):
        if first[i] > 0.5:
            dd, dv, vv = start[i, 0], start[i, 1], start[i, 2]
        out[i] = np.sqrt(max(vv, 0.0))
        if i + 1 < n:
            dt = t[i + 1] - t[i]
            a, b = -dt * pull[i, 0], 1.0 - dt * pull[i, 1]
            vv, dv, dd = (
                a * a * dd + 2.0 * a * b * dv + b * b * vv + (push[i] * dt) ** 2,
                a * dd + (b + a * dt) * dv + b * dt * vv,
                dd + 2.0 * dt * dv + dt * dt * vv,
            )
    return out
