"""The least grip force that would have held, over the course of a run.

The definition is that of :mod:`vegrip.trials.grip_quality`: of every finger the normal force
at which its true load lies on the limit surface of its true contact, the radius going with the cube root of
the force; of the grasp, the larger of the first finger's and of the sum of the others'.
"""

import math

import numpy as np

from vegrip.contact.limit_surface.fast import least_normal_force
from vegrip.trials.closed_loop import Course
from vegrip.types import Floats

HERTZ_POWER = 1.0 / 3.0


def least_grip_force(course: Course) -> Floats:
    """Return the least possible grip force [N] at every time of ``course``; NaN without contact."""
    rows = [
        [_least(force, *contact) for force, contact in zip(forces, contacts, strict=True)]
        for forces, contacts in zip(course.force, course.contact, strict=True)
    ]
    if not rows:
        return np.zeros(0)
    each = np.array(rows)
    larger: Floats = np.maximum(each[:, 0], each[:, 1:].sum(axis=1))
    return larger


def force_over_least(course: Course, start: float) -> float:
    """Return the sum of the grip force over the sum of the least from ``start`` [s] on; NaN if never held."""
    least, force = least_grip_force(course), np.array([forces[0] for forces in course.force])
    counted = (np.array(course.time) >= start) & np.isfinite(least)
    if not counted.any() or not least[counted].sum() > 0.0:
        return math.nan
    return float(force[counted].sum() / least[counted].sum())


def _least(force: float, tangential: float, torque: float, mu: float, radius: float, k: float) -> float:
    if not (force > 0.0 and radius > 0.0):
        return math.nan
    return float(least_normal_force(tangential, torque, mu, radius, k, force, HERTZ_POWER, 0.0))
