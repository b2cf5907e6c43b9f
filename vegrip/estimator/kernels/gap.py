"""A pause in which nothing was heard: the tip may have left the object, and touched it again.

In the air now, it was released at any instant of the pause with the same chance: what remains of a memory
``s`` that decays to ``r s`` in the air has the mean ``s (1 - r) / -ln r``. In contact now, the memory may be
anything that is possible at this indentation.
"""

import math

from vegrip.estimator.kernels.begin import begin_contact, named, share_of
from vegrip.estimator.kernels.generated import (
    BEND0,
    DELTA,
    EFFECTS,
    MODE_ZERO_KNOWN,
    NS,
    OLD0,
    P0,
    SET_TIP_RADIUS,
    STATE_HIGH,
    TRIAL0,
    TRY0,
    Y0,
    Floats,
    N,
)
from vegrip.estimator.kernels.predict import walk
from vegrip.estimator.kernels.state import contact, copy_state, propagate


def bridge_gap(m: Floats, dt: float, force: float, displacement: float) -> None:
    """Carry what is known over a pause of ``dt`` [s]."""
    zero_known = m[MODE_ZERO_KNOWN]
    walk(m, dt)
    copy_state(m)
    for i in range(NS):
        m[TRY0 + EFFECTS + i] = largest_memory(m, i)
    m[TRY0 + DELTA] = -m[SET_TIP_RADIUS]
    propagate(m, TRY0, -m[SET_TIP_RADIUS], 0.0, dt, TRIAL0)
    for i in range(NS):
        m[BEND0 + i] = m[TRY0 + EFFECTS + i]
        m[OLD0 + i] = m[TRIAL0 + i]
    begin_contact(m, force, displacement)
    if m[MODE_ZERO_KNOWN] < 0.5:
        m[MODE_ZERO_KNOWN] = zero_known
        return
    for i in range(NS):
        before = m[BEND0 + i]
        left = min(max(m[OLD0 + i] / before, 1e-12), 1.0) if before != 0.0 else 1.0
        mean, square = remaining(left)
        m[Y0 + EFFECTS + i] = before * mean
        m[P0 + (EFFECTS + i) * N + EFFECTS + i] = before * before * max(square - mean * mean, 0.0)


def largest_memory(m: Floats, i: int) -> float:
    """Return what effect state ``i`` was, or could have become in a hold."""
    x, elastic_force, force, _ = contact(m, Y0)
    if STATE_HIGH[i] == 0:
        return float(m[Y0 + EFFECTS + i])
    return float(max(m[Y0 + EFFECTS + i], share_of(m, i) * named(STATE_HIGH[i], x, elastic_force, force)))


def remaining(left: float) -> tuple[float, float]:
    """Mean and mean square of ``left^u``, u even between 0 and 1."""
    if left > 0.999:
        return 1.0, 1.0
    decades = -math.log(left)
    return (1.0 - left) / decades, (1.0 - left * left) / (2.0 * decades)
