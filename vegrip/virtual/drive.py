"""The force-controlled drives: bandwidth, rate limit, stiction, and what they do without commands.

A drive moves its fingertip along the face normal. It tracks the commanded force, limited in rate, with a
first-order force loop; a force error below the stiction moves nothing. Without a valid command the drive
holds its **position** (a worm gear does; a hand that let go would be the worse choice), so the force of the
soft tip relaxes.
"""

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.settings import ActuatorSettings


class Drives:
    """The drives of the opposed fingers, moved together."""

    def __init__(self, settings: ActuatorSettings, count: int) -> None:
        s = settings
        self.position = np.zeros(count)  # [m] towards the object
        self.target = np.full(count, np.nan)  # [N] what the force loop follows now; NaN = holds its position
        self.limits = np.array([s.force_limit, s.force_rate, s.stiction, s.speed, s.bandwidth])

    def move(self, wanted: Floats, force: Floats, stiffness: Floats, dt: float) -> None:
        """Move for ``dt`` [s] towards the ``wanted`` forces [N]; NaN holds the position.

        ``force`` [N] and ``stiffness`` [N/m] are those of the contacts now.
        """
        kernels.move_drives(self.position, self.target, self.limits, wanted, force, stiffness, dt)
