"""What a run comes down to: slips, drops, force and margin."""

import math
from dataclasses import dataclass

import numpy as np

from vegrip.trials.closed_loop import Course
from vegrip.trials.scenario import SETTLED_S


@dataclass(frozen=True, slots=True)
class Result:
    """Figures of one run, from the truth of the hand, not from an estimate.

    Grip force is the normal force on the first finger, which equals the sum of what the others press.
    """

    slips: int
    dropped: bool
    mean_grip_force: float  # [N] while the object was held
    peak_grip_force: float  # [N]
    min_margin: float  # [-] least of all fingers; zero or less on the limit surface


def result_of(course: Course, until: float = math.inf) -> Result:
    """Sum up ``course`` from the time on that the hand carries the object.

    Force and margin are those up to ``until`` [s].
    """
    time, margin, force = course.since(SETTLED_S)
    margin, force = margin[time <= until], force[time <= until]
    if not len(force):
        return Result(course.slips, course.dropped, math.nan, math.nan, math.nan)
    return Result(
        slips=course.slips,
        dropped=course.dropped,
        mean_grip_force=float(np.mean(force[:, 0])),
        peak_grip_force=float(np.max(force[:, 0])),
        min_margin=float(np.min(margin)),
    )
