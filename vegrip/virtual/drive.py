"""The force-controlled drives: bandwidth, rate limit, stiction, and what they do without commands.

A drive moves its fingertip along the face normal. It tracks the commanded force, limited in rate, with a
first-order force loop; a force error below the stiction moves nothing. Without a valid command the drive
holds its **position** (a worm gear does; a hand that let go would be the worse choice), so the force of the
soft tip relaxes.
"""

import math

import numpy as np

from vegrip.types import Floats
from vegrip.virtual.settings import ActuatorSettings


class Drives:
    """The drives of the opposed fingers, moved together."""

    def __init__(self, settings: ActuatorSettings, count: int) -> None:
        self.settings = settings
        self.position = np.zeros(count)  # [m] towards the object
        self.target = np.full(count, np.nan)  # [N] what the force loop follows now; NaN = holds its position

    def move(self, wanted: Floats, force: Floats, stiffness: Floats, dt: float) -> None:
        """Move for ``dt`` [s] towards the ``wanted`` forces [N]; NaN holds the position.

        ``force`` [N] and ``stiffness`` [N/m] are those of the contacts now.
        """
        s = self.settings
        start = np.where(np.isnan(self.target), force, self.target)
        self.target = start + within(s.force_rate * dt, within(s.force_limit, wanted, 0.0) - start)
        error = self.target - force
        pull = error - within(s.stiction, error)
        speed = within(s.speed, 2.0 * math.pi * s.bandwidth * pull / stiffness)
        self.position += dt * np.where(np.isnan(speed), 0.0, speed)


def within(limit: float, values: Floats, low: float | None = None) -> Floats:
    """Return ``values`` held between -limit (or ``low``) and limit; NaN stays NaN."""
    held: Floats = np.minimum(np.maximum(values, -limit if low is None else low), limit)
    return held


def share(first: float, others: Floats) -> Floats:
    """Return the forces of the opposed fingers [N] when the first finger is to carry ``first`` [N].

    The first finger carries the sum of the others. If it asks for more, all of them give more in proportion
    (or evenly, if they ask for nothing); it can never make them give less. NaN = no valid command.
    """
    asked = float(np.nansum(others))
    if not first > asked:  # NaN included
        return others
    if asked > 0.0:
        return others * (first / asked)
    return np.where(np.isnan(others), np.nan, first / max(1, int(np.sum(~np.isnan(others)))))
