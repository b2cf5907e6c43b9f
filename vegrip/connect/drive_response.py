"""What a drive makes of its setting, from a run on a stiff object: gain, steps, delay, hysteresis. Pure.

A run is settings [N], each with the time from which on it was asked for, and the force that sensors felt::

    up      from the least to the largest setting
    down    back again
    back    to the middle, from below
    fine    from there on up by steps finer than those of the drive

At each setting the force is taken over the second half of its time, when it stands. With F up and down at
the same setting s, gain a and offset b are those of (F_up + F_down) / 2 = a s + b, and the hysteresis is the
median of F_down - F_up.
"""

import math
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple

import numpy as np

from vegrip.errors import InputError
from vegrip.types import Floats

Stage = Literal["up", "down", "back", "fine"]
SEEN: Final = 5.0
"""Standard errors from which on two forces differ."""
MOST_OF_DWELL: Final = 0.4
"""Share of the time at a setting within which its step must be over, so that the second half stands."""
CONTINUOUS: Final = 0.6
"""Share of the fine settings that change the force, from which on they are coarser than the drive's steps."""
LEAST_LEVELS: Final = 4


class Change(NamedTuple):
    """A setting that was asked for."""

    at: float  # [s]
    setting: float  # [N]
    stage: Stage


@dataclass(frozen=True)
class DriveRun:
    """What was asked for and felt."""

    changes: tuple[Change, ...]
    end: float  # [s] of the last setting
    time: Floats  # [s] (n,)
    force: Floats  # [N] (n,)

    def held(self, number: int) -> tuple[float, float]:
        """Return the force [N] at a setting, and its standard error."""
        begin, end = self.span(number)
        return _mean(self.force[(self.time >= (begin + end) / 2.0) & (self.time < end)])

    def span(self, number: int) -> tuple[float, float]:
        """Return from when to when [s] a setting was asked for."""
        later = self.changes[number + 1 :]
        return self.changes[number].at, later[0].at if later else self.end


class Found(NamedTuple):
    """A value and its standard error."""

    value: float
    std: float


@dataclass(frozen=True)
class DriveResponse:
    """What was measured; forces are those that the sensors feel."""

    gain: Found  # felt force over setting
    offset: Found  # [N] felt at a setting of zero, if the line went on
    curved: float  # [N] by which the line is wrong at most
    delay: Found  # [s] from the command to half of the step
    hysteresis: Found  # [N] felt more on the way down than on the way up
    resolution: Found  # [N] one step; NaN: none was seen
    finer: float  # [N] the steps are finer than this, or not seen; NaN: they were seen
    range: tuple[float, float]  # [N] of the settings

    @property
    def settings(self) -> dict[str, float]:
        """``[drive]`` as far as it was measured, in newtons that are felt."""
        found = {"delay": round(self.delay.value, 4), "hysteresis": round(self.hysteresis.value, 3)}
        if not math.isnan(self.resolution.value):
            found["resolution"] = round(self.resolution.value, 3)
        return found

    def felt(self, setting: float) -> float:
        return self.gain.value * setting + self.offset.value

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, a standard error beside its value as ``NAME_std``."""
        found: dict[str, Any] = {}
        for name, each in vars(self).items():
            found |= {name: each.value, f"{name}_std": each.std} if isinstance(each, Found) else {name: each}
        return found


def respond(run: DriveRun) -> DriveResponse:
    """Return what the drive made of its settings.

    Raises:
        InputError: the force does not follow the settings, or not in their time.

    """
    held = [run.held(number) for number in range(len(run.changes))]
    if any(math.isnan(force) for force, _ in held):
        raise InputError("there are settings at which the sensors said nothing; run it again")
    up, down = (
        {c.setting: f for c, f in zip(run.changes, held, strict=True) if c.stage == s} for s in ("up", "down")
    )
    both = sorted(up.keys() & down.keys())
    if len(both) < LEAST_LEVELS:
        raise InputError(f"only {len(both)} settings were held both ways, and {LEAST_LEVELS} are needed")
    level = np.array(both)
    rising, falling = (np.array([each[s][0] for s in both]) for each in (up, down))
    gain, offset, curved = _line(level, (rising + falling) / 2.0)
    if gain.value <= SEEN * gain.std:
        raise InputError(
            "the force that the sensors feel does not follow the settings: is the object between the pads "
            "and stiff, and do the pads feel along the closing direction?"
        )
    resolution, finer = _resolution(run, held)
    most = float(max(each.setting for each in run.changes))
    return DriveResponse(
        gain, offset, curved, _delay(run, held), _hysteresis(falling - rising), resolution, finer,
        (float(level[0]), most),
    )  # fmt: skip


def _mean(force: Floats) -> tuple[float, float]:
    if len(force) < 2:
        return math.nan, math.nan
    return float(force.mean()), float(force.std(ddof=1) / math.sqrt(len(force)))


def _line(x: Floats, y: Floats) -> tuple[Found, Found, float]:
    """Return slope and offset of y = a x + b with standard errors, and the largest error of the line."""
    basis = np.stack([x, np.ones_like(x)], axis=1)
    (a, b), *_ = np.linalg.lstsq(basis, y, rcond=None)
    rest = y - basis @ np.array([a, b])
    spread = np.linalg.inv(basis.T @ basis) * (rest @ rest) / (len(x) - 2)
    errors = np.sqrt(np.diag(spread))
    return Found(float(a), float(errors[0])), Found(float(b), float(errors[1])), float(np.abs(rest).max())


def _hysteresis(difference: Floats) -> Found:
    """Return the median of F_down - F_up [N]; less than nothing is noise."""
    middle = float(np.median(difference))
    spread = 1.4826 * float(np.median(np.abs(difference - middle)))  # of a normal distribution
    return Found(max(middle, 0.0), spread / math.sqrt(len(difference)))


def _delay(run: DriveRun, held: list[tuple[float, float]]) -> Found:
    """Return the median time [s] from a command to the first force beyond half of its step."""
    found = []
    for number in range(1, len(run.changes)):
        (before, before_std), (after, after_std) = held[number - 1], held[number]
        begin, end = run.span(number)
        inside = (run.time >= begin) & (run.time < end)
        time, force = run.time[inside], run.force[inside]
        noise = math.sqrt(len(force) / 2) * max(before_std, after_std)  # [N] of a sample
        if abs(after - before) < 2.0 * SEEN * noise or run.changes[number].stage == "fine":
            continue
        at = int(np.argmax((force - (before + after) / 2.0) * math.copysign(1.0, after - before) >= 0.0))
        if time[at] - begin > MOST_OF_DWELL * (end - begin):
            raise InputError(
                f"the force came {time[at] - begin:.2f} s after the command, too late for the "
                f"{end - begin:.2f} s of a setting; state the drive's 'delay' in [drive] of its map, "
                "and run it again"
            )
        found.append(float(time[at] - begin))
    if len(found) < LEAST_LEVELS:
        raise InputError(
            "too few steps of the force stand out of the noise of the sensors to measure the delay"
        )
    return Found(float(np.median(found)), float(np.std(found, ddof=1) / math.sqrt(len(found))))


def _resolution(run: DriveRun, held: list[tuple[float, float]]) -> tuple[Found, float]:
    """Return one step of the force [N], and, where none is seen, what it is finer than."""
    unknown = Found(math.nan, math.nan)
    fine = [number for number, each in enumerate(run.changes) if each.stage == "fine"]
    if not fine:
        return unknown, math.nan
    force = np.array([held[number][0] for number in (fine[0] - 1, *fine)])
    noise = SEEN * math.sqrt(2.0) * max(held[number][1] for number in fine)
    steps = np.diff(force)
    jumps = steps[steps > max(noise, 0.5 * float(steps.max()))]
    if len(jumps) < 2:
        return unknown, noise if not len(jumps) and force[-1] - force[0] > noise else math.nan
    if len(jumps) > CONTINUOUS * len(steps):
        return unknown, float(np.median(steps))
    return Found(float(jumps.mean()), float(jumps.std(ddof=1) / math.sqrt(len(jumps)))), math.nan
