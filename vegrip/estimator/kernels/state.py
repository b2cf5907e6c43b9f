"""The state in the memory, and the model seen from it."""

import math

from vegrip.estimator.kernels.generated import *

DEEPEST = 3.0  # tip radii; the force there is 5 times that at one, which a stiffness that is a guess may miss


def clear_section(m: Floats, start: int, end: int) -> None:
    """Set a section to zero."""
    for i in range(start, end):
        m[i] = 0.0


def copy_section(m: Floats, source: int, target: int, length: int) -> None:
    """Copy ``length`` numbers from the section at ``source`` to that at ``target``."""
    for i in range(length):
        m[target + i] = m[source + i]


def copy_state(m: Floats) -> None:
    """Copy the state to TRY, the one that is varied."""
    copy_section(m, Y0, TRIED0, N)


def put_learned(m: Floats, y: int) -> None:
    """Write the learned parameters of the state ``y`` into the values the model reads."""
    for j in range(N_LEARNED):
        u = m[y + LEARNED_FROM + j]
        m.values[LEARNED[j]] = math.exp(u) if LEARNED_LOG[j] else u


def difference_step(m: Floats, y: int, j: int) -> float:
    """Difference step of coordinate ``j``: a thousandth of its standard deviation."""
    sd = math.sqrt(max(m.p[j * N + j], 0.0))
    return float(max(1e-3 * sd, 1e-8 * abs(m[y + j])))


def contact(m: Floats, y: int) -> tuple[float, float, float, float]:
    """``x``, ``elastic_force``, ``force``, ``sensed_force`` of the state ``y``."""
    put_learned(m, y)
    return advance(m, VALUES0, y + EFFECTS, m[y + DELTA], m[y + SPEED], EXOGENOUS0, 0.0, 0.0, TRIAL0)


def propagate(m: Floats, y: int, delta: float, speed: float, dt: float, into: int) -> None:
    """Effect states after ``dt``, in which the indentation goes from that of ``y`` to ``delta`` [m]."""
    put_learned(m, y)
    _, before, _, _ = advance(m, VALUES0, y + EFFECTS, m[y + DELTA], m[y + SPEED], EXOGENOUS0, 0.0, 0.0, into)
    advance(m, VALUES0, into, delta, speed, EXOGENOUS0, before, dt, into)


def bound_state(m: Floats) -> None:
    """Keep the state where the model makes sense."""
    y = Y0
    R = m.set.tip_radius
    m[y + DELTA] = min(max(m[y + DELTA], -100.0 * R), DEEPEST * R)
    for j in range(LEARNED_FROM, M):
        m[y + j] = min(max(m[y + j], m.low[j]), m.high[j])


def walk_within(m: Floats, j: int, grown: float, limit: float) -> None:
    """Add ``grown`` to the variance of coordinate ``j``, as far as it stays below ``limit``."""
    variance = m.p[j * N + j]
    m.p[j * N + j] = max(variance, min(variance + grown, limit))
