"""The zeros of each trial: a sensor is switched on, warms and is mounted anew between two of them.

A fit has one zero for all that it is given. A zero that differs from trial to trial by half the noise of the
force put the stiffness of a soft fingertip ten standard errors off. Each trial begins in the air, so each
tells its own.
"""

from dataclasses import replace

import numpy as np

from vegrip.identification.fit.noise import in_air
from vegrip.identification.recording import Recording

FORCE_CHANNELS = ("normal_force", "tangential_force_x", "tangential_force_y", "torque_z")
LEAST_ROWS = 20  # in the air, from which a mean is better than the zero that was set


def without_zeros(recording: Recording) -> Recording:
    """Return ``recording`` with its loads counted from their means in the air."""
    air = in_air(recording)
    columns = dict(recording.columns)
    for name in FORCE_CHANNELS:
        values = columns.get(name)
        known = air & np.isfinite(values) if values is not None else air
        if values is not None and np.count_nonzero(known) >= LEAST_ROWS:
            columns[name] = values - float(np.mean(values[known]))
    return replace(recording, columns=columns)
