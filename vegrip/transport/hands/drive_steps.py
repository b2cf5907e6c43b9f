"""Which force a drive is commanded, of those that it can make, for the force that is needed. Pure.

A drive makes the forces ``minimum + i resolution`` up to ``maximum``, and none (open). A change of less than
its ``hysteresis`` may do nothing, and within ``1 / rate`` of the last it is not taken. So the need is rounded
up, followed up at once, and down where it stays lower:

* by a step for :data:`CALM_NS`;
* by :data:`FAR_STEPS` steps, and a tenth, for :data:`FALL_NS`: the load is another one.

Both leave a part of a step between what was needed meanwhile and what is commanded then, so that under a
constant load a need that wavers moves no drive back and forth.
"""

import math
from typing import Final, NamedTuple

from vegrip.clock import NOT_YET, NS
from vegrip.grip.safety.drive import DriveLimits

OPEN_N: Final = 0.05  # [N] less than this asks to open
TOUCH_N: Final = 1.0  # [N] below which nothing may be held, but touched
CALM_NS: Final = 10 * NS
FALL_NS: Final = NS // 2  # between two peaks of the load of an object that is shaken at 1 Hz
FAR_STEPS: Final = 2
FAR_SHARE: Final = 0.1  # of the force; the need of a firm grip wavers by the dead band of 0.04
STEP_SHARE: Final = 0.25  # of a step, left above a need that has fallen
FORCE_SHARE: Final = 0.02  # of the force, the same for a drive without steps
MUCH_MORE: Final = 1.5  # times the need, from which on the least force is said to be more than that
EXACT: Final = 1e-9  # of a step: what rounding leaves


class Lower(NamedTuple):
    """Since when a lower force would do [ns], and the most that was needed since [N]."""

    since: int = NOT_YET
    most: float = 0.0

    def grown(self, need: float, bound: float, now: int) -> "Lower":
        return Lower(self.since, max(self.most, need)) if need <= bound else Lower(now)


class Commanded(NamedTuple):
    """What a drive was commanded last."""

    force: float = 0.0  # [N]
    at: int = NOT_YET  # [ns] when it changed
    step: Lower = Lower()
    far: Lower = Lower()


def step_above(drive: DriveLimits, force: float) -> float:
    """Return the least force [N] of ``drive`` that is not below ``force``, else its largest."""
    if force <= drive.minimum or drive.resolution == 0.0:
        return min(max(force, drive.minimum), drive.maximum)
    steps = math.ceil((force - drive.minimum) / drive.resolution - EXACT)
    if math.isfinite(drive.maximum):
        steps = min(steps, math.floor((drive.maximum - drive.minimum) / drive.resolution + EXACT))
    return drive.minimum + steps * drive.resolution


def next_force(drive: DriveLimits, commanded: Commanded, need: float, now: int) -> Commanded:
    """Return what ``drive`` is commanded at ``now`` [ns] for a ``need`` [N]."""
    if need < OPEN_N:
        return commanded if commanded.force == 0.0 else Commanded(0.0, now)
    if commanded.force == 0.0:
        return _changed(step_above(drive, need), now)
    least = max(drive.resolution, drive.hysteresis)
    rest = max(STEP_SHARE * least, FORCE_SHARE * commanded.force)
    step = commanded.step.grown(need, commanded.force - least - rest, now)
    far = commanded.far.grown(
        need, commanded.force - max(FAR_STEPS * least, FAR_SHARE * commanded.force) - rest, now
    )
    if drive.rate > 0.0 and now - commanded.at < NS / drive.rate:
        return commanded._replace(step=step, far=far)
    if need > commanded.force * (1.0 + EXACT):
        more = max(drive.hysteresis, FORCE_SHARE * commanded.force)
        force = step_above(drive, max(need, commanded.force + more))
        return _changed(force, now) if force > commanded.force else commanded
    lower = [each for each, wait in ((step, CALM_NS), (far, FALL_NS)) if now - each.since >= wait]
    force = min((step_above(drive, each.most + rest) for each in lower), default=commanded.force)
    return _changed(force, now) if force < commanded.force else commanded._replace(step=step, far=far)


def _changed(force: float, now: int) -> Commanded:
    return Commanded(force, now, Lower(now), Lower(now))


def range_of(drive: DriveLimits) -> str:
    """Return which forces ``drive`` makes, for a sentence."""
    most = f" to {drive.maximum:g} N" if math.isfinite(drive.maximum) else " N on"
    steps = f" in steps of {drive.resolution:g} N" if drive.resolution else ""
    return f"{drive.minimum:g}{most}{steps}"


def least_force_sentence(drive: DriveLimits, need: float) -> str:
    """Return that the least force of ``drive`` is far more than the ``need`` [N], "" where it is not."""
    if not TOUCH_N <= need < drive.minimum / MUCH_MORE:
        return ""
    ratio = drive.minimum / need
    return f"the least that this gripper can is {drive.minimum:g} N, {ratio:.2g} times what is needed"
