"""The load that counts: a sample far off the last one counts only as far as the next one confirms it.

A lone sample that is wrong looks like a sudden load, and every newton of it would be answered. Loads on an
object come over several samples. So each component v of the load (tangential force x and y, torque) is
clipped to what it counted as last, c, and to the sample before it, p, give or take a band::

    c = v within min(c, p) - band ... max(c, p) + band,    band = CONFIRM_PART |load| + CONFIRM_NOISE std .

With no band that is a median of three. A load that changes by less than the band from sample to sample counts
at once, and any other one sample later at most.

Plain scalar code over CONFIRM_SIZE numbers of ``q`` from ``at`` on, not numbers at first; the same text is
compiled.
"""

import math

from vegrip.types import Numbers

CONFIRM_BEFORE = 3  # behind what x, y [N] and torque [N m] count as: the sample before
CONFIRM_SIZE = 6

CONFIRM_PART = 0.25
CONFIRM_NOISE = 6.0  # standard deviations


def confirm_load(
    q: Numbers, at: int, x: float, y: float, torque: float, noise: float, torque_noise: float
) -> tuple[float, float, float]:
    """Take in one sample of a load, whose noise has the std ``noise`` [N], ``torque_noise`` [N m].

    Return as what it counts. What is not a number counts as that, and the sample after it as it is.
    """
    before_x, before_y = q[at], q[at + 1]
    band = CONFIRM_PART * math.sqrt(before_x * before_x + before_y * before_y) + CONFIRM_NOISE * noise
    turning_band = CONFIRM_PART * abs(q[at + 2]) + CONFIRM_NOISE * torque_noise
    return (
        confirm_component(q, at, x, band),
        confirm_component(q, at + 1, y, band),
        confirm_component(q, at + 2, torque, turning_band),
    )


def confirm_component(q: Numbers, at: int, value: float, band: float) -> float:
    """Return as what one component counts."""
    counted, before = q[at], q[at + CONFIRM_BEFORE]
    q[at + CONFIRM_BEFORE] = value
    q[at] = value
    if abs(value) + abs(counted) + abs(before) + band < math.inf:
        q[at] = min(max(value, min(counted, before) - band), max(counted, before) + band)
    return q[at]
