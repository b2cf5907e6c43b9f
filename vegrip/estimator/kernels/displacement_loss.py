"""Losing the displacement: what force alone shows."""

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.state import contact, difference_step


def follow_displacement_loss(m: Floats, blind: bool) -> None:
    """Note whether the displacement is measured, and what changes when it is lost."""
    was = m.mode.blind > 0.0
    m.mode.blind = 1.0 if blind else 0.0
    if blind:
        m.motion.restless = 1.0
    if blind and not was:
        lose_displacement(m)


def lose_displacement(m: Floats) -> None:
    """No displacement any more: from here on the indentation is the one the present parameters give.

    Force alone does not distinguish stiffness from indentation, and a filter linearised anew at every force
    believes that it can. So the parameters are taken as known in the filter, uncorrelated with the rest, and
    their spread enters where something is published, at constant force (``slope_at_constant_force``).
    """
    for i in range(LEARNED_FROM, M):
        for j in range(N):
            if not LEARNED_FROM <= j < M:
                m.p[i * N + j] = 0.0
                m.p[j * N + i] = 0.0


def slope_at_constant_force(m: Floats, y: int, j: int) -> float:
    """Change of the indentation with learned parameter ``j`` at constant force, ``- N_theta / N_delta``."""
    base = contact(m, y)[2]
    keep, h = m[y + DELTA], difference_step(m, y, 0)
    m[y + DELTA] = keep + h
    by_depth = (contact(m, y)[2] - base) / h if h > 0.0 else 0.0
    m[y + DELTA] = keep
    keep, h = m[y + j], difference_step(m, y, j)
    m[y + j] = keep + h
    by_parameter = (contact(m, y)[2] - base) / h if h > 0.0 else 0.0
    m[y + j] = keep
    return -by_parameter / by_depth if by_depth > 0.0 else 0.0
