"""A pause in which nothing was received: the tip may have left the object, and touched it again.

In the air before and after, it recovered as it does between two samples. In contact before and in the air
now, it was released at any instant of the pause with the same chance: what remains of a memory ``s`` that
decays to ``r s`` in the air has the mean ``s (1 - r) / -ln r``. In contact now, the memory may be anything
that is possible at this indentation.
"""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.initialisation import begin_contact, bound_scale, bounding_quantity, is_touching
from vegrip.estimator.kernels.motion import begin_motion
from vegrip.estimator.kernels.predict import add_random_walks, predict
from vegrip.estimator.kernels.state import bound_state, contact, copy_section, copy_state, propagate

RECOVERY_STEPS = 60  # into which a pause is cut


def bridge_gap(m: Floats, dt: float, force: float, displacement: float) -> None:
    """Carry what is known over a pause of ``dt`` [s]."""
    if m.report.contact == 0.0 and math.isfinite(displacement) and not is_touching(m, force):
        m.mode.corner = 0.0
        for i in range(RECOVERY_STEPS):
            predict(m, gap_step(dt, i), displacement)
            bound_state(m)
        begin_motion(m, displacement)
        return
    zero_known = m.mode.zero_known
    add_random_walks(m, dt)
    for i in range(NS):
        for j in range(N):
            m.b[i * N + j] = m.p[(EFFECTS + i) * N + j]
    copy_state(m)
    for i in range(NS):
        m.tried[EFFECTS + i] = largest_memory(m, i)
    m.tried[DELTA] = -m.set.tip_radius
    for i in range(NS):
        m.bend[i] = m.tried[EFFECTS + i]
    for i in range(RECOVERY_STEPS):
        propagate(m, TRIED0, -m.set.tip_radius, 0.0, gap_step(dt, i), TRIAL0)
        copy_section(m, TRIAL0, TRIED0 + EFFECTS, NS)
    copy_section(m, TRIAL0, OLD0, NS)
    begin_contact(m, force, displacement)
    if m.mode.zero_known == 0.0:
        m.mode.zero_known = zero_known
        return
    for i in range(NS):
        before = m.bend[i]
        left = min(max(m.old[i] / before, 1e-12), 1.0) if before != 0.0 else 1.0
        mean, square = mean_decay(left)
        z = EFFECTS + i
        m.y[z] = before * mean
        for j in range(LEARNED_FROM, N):
            m.p[z * N + j] = m.p[j * N + z] = mean * m.b[i * N + j]
        m.p[z * N + DELTA] = m.p[DELTA * N + z] = -m.p[z * N + OFFSET]
        spread = before * before * max(square - mean * mean, 0.0)
        m.p[z * N + z] = mean * mean * m.b[i * N + z] + spread


def gap_step(dt: float, i: int) -> float:
    """Return the step ``i`` of the pause ``dt`` [s]: short first, while the memory is large.

    A step is exact for an elastic force that is linear in time; that of a free surface decays exponentially.
    """
    before, after = i / RECOVERY_STEPS, (i + 1) / RECOVERY_STEPS
    return dt * (after * after * after - before * before * before)


def largest_memory(m: Floats, i: int) -> float:
    """Return what effect state ``i`` was, or could have become in a hold."""
    x, elastic_force, force, _ = contact(m, Y0)
    if STATE_HIGH[i] == 0:
        return float(m.y[EFFECTS + i])
    return float(
        max(m.y[EFFECTS + i], bound_scale(m, i) * bounding_quantity(STATE_HIGH[i], x, elastic_force, force))
    )


def mean_decay(left: float) -> tuple[float, float]:
    """Mean and mean square of ``left^u``, u even between 0 and 1."""
    if left > 0.999:
        return 1.0, 1.0
    decades = -math.log(left)
    return (1.0 - left) / decades, (1.0 - left * left) / (2.0 * decades)
