"""What a drive makes of its setting, from a run on a stiff object: gain, steps, delay, hysteresis. Pure.

A run is settings [N], each with the time from which on it was asked for, and the force that sensors felt::

    up      from the least to the largest setting
    down    back again
    back    to the middle, from below
    fine    from there on up by steps finer than those of the drive

At each setting the force is taken over the second half of its time, when it stands. With F up and down at
the same setting s, gain a and offset b are those of (F_up + F_down) / 2 = a s + b, and the hysteresis is the
median of F_down - F_up. Where F_down hardly falls, a smaller setting loosens no grip: F_up alone counts.
"""

import math
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple

import numpy as np
from scipy import stats

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
LOOSENED: Final = 0.5
"""Of what the force rises by, that it falls by at least where smaller settings loosen the grip."""


class Change(NamedTuple):
    """A setting that was asked for."""

    at: float  # [s]
    setting: float  # [N]
    stage: Stage


class Found(NamedTuple):
    """A value and its standard error."""

    value: float
    std: float


UNKNOWN: Final = Found(math.nan, math.nan)


@dataclass(frozen=True)
class DriveRun:
    """What was asked for and felt."""

    changes: tuple[Change, ...]
    end: float  # [s] of the last setting
    time: Floats  # [s] (n,)
    force: Floats  # [N] (n,)

    def felt(self, number: int, begin: float = 0.0) -> tuple[Floats, Floats]:
        """Return times [s] since a setting was asked for and forces [N], from a share of its time on."""
        first = self.changes[number].at
        last = self.changes[number + 1].at if number + 1 < len(self.changes) else self.end
        inside = (self.time >= first + begin * (last - first)) & (self.time < last)
        return self.time[inside] - first, self.force[inside]

    def held(self, number: int) -> Found:
        """Return the force [N] at a setting."""
        _, force = self.felt(number, 0.5)
        return Found(float(force.mean()), float(stats.sem(force))) if len(force) > 1 else UNKNOWN


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
    loosens: bool  # whether a smaller setting makes the force of a grip that stands smaller

    @property
    def settings(self) -> dict[str, float]:
        """``[drive]`` as far as it was measured, in newtons that are felt."""
        found = {"delay": round(self.delay.value, 4)}
        found |= {"hysteresis": round(self.hysteresis.value, 3)} if self.loosens else {}
        step = self.resolution.value
        return found if math.isnan(step) else {**found, "resolution": round(step, 3)}

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
    if any(math.isnan(each.value) for each in held):
        raise InputError("there are settings at which the sensors said nothing; run it again")
    up, down = (
        {c.setting: f.value for c, f in zip(run.changes, held, strict=True) if c.stage == s}
        for s in ("up", "down")
    )
    both = sorted(up.keys() & down.keys())
    if len(both) < LEAST_LEVELS:
        raise InputError(f"only {len(both)} settings were held both ways, and {LEAST_LEVELS} are needed")
    level = np.array(both)
    rising, falling = (np.array([each[s] for s in both]) for each in (up, down))
    loosens = bool(np.ptp(falling) >= LOOSENED * np.ptp(rising))
    middle, apart = (rising + falling) / 2.0 if loosens else rising, falling - rising
    line = stats.linregress(level, middle)
    if line.slope <= SEEN * line.stderr:
        raise InputError(
            "the force that the sensors feel does not follow the settings: is the object between the pads "
            "and stiff, and do the pads feel along the closing direction?"
        )
    spread = float(stats.median_abs_deviation(apart, scale="normal"))
    resolution, finer = _resolution(run, held)
    return DriveResponse(
        gain=Found(float(line.slope), float(line.stderr)),
        offset=Found(float(line.intercept), float(line.intercept_stderr)),
        curved=float(np.abs(middle - line.slope * level - line.intercept).max()),
        delay=_delay(run, held),
        hysteresis=Found(max(float(np.median(apart)), 0.0), spread / math.sqrt(len(apart))),
        resolution=resolution,
        finer=finer,
        range=(both[0], max(each.setting for each in run.changes)),
        loosens=loosens,
    )


def _delay(run: DriveRun, held: list[Found]) -> Found:
    """Return the median time [s] from a command to the first force beyond half of its step."""
    found = []
    for number in range(1, len(run.changes)):
        before, after = held[number - 1], held[number]
        time, force = run.felt(number)
        noise = math.sqrt(len(force) / 2) * max(before.std, after.std)  # [N] of a sample
        step = after.value - before.value
        if abs(step) < 2.0 * SEEN * noise or run.changes[number].stage == "fine":
            continue
        late = time[np.argmax((force - before.value) / step >= 0.5)]
        if late > MOST_OF_DWELL * time[-1]:
            raise InputError(
                f"the force came {late:.2f} s after the command, too late for the {time[-1]:.2f} s of a "
                "setting; state the drive's 'delay' in [drive] of its map, and run it again"
            )
        found.append(float(late))
    if len(found) < LEAST_LEVELS:
        raise InputError(
            "too few steps of the force stand out of the noise of the sensors to measure the delay"
        )
    return Found(float(np.median(found)), float(stats.sem(found)))


def _resolution(run: DriveRun, held: list[Found]) -> tuple[Found, float]:
    """Return one step of the force [N], and, where none is seen, what it is finer than."""
    fine = [number for number, each in enumerate(run.changes) if each.stage == "fine"]
    if not fine:
        return UNKNOWN, math.nan
    force = np.array([held[number].value for number in (fine[0] - 1, *fine)])
    noise = SEEN * math.sqrt(2.0) * max(held[number].std for number in fine)
    steps = np.diff(force)
    jumps = steps[steps > max(noise, 0.5 * float(steps.max()))]
    if len(jumps) < 2:
        return UNKNOWN, noise if not len(jumps) and force[-1] - force[0] > noise else math.nan
    if len(jumps) > CONTINUOUS * len(steps):
        return UNKNOWN, float(np.median(steps))
    return Found(float(jumps.mean()), float(stats.sem(jumps))), math.nan
