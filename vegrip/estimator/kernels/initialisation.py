"""The first sample, and beginning anew what is no longer believed: states of nothing known."""

import math

from vegrip.estimator.kernels.displacement_loss import lose_displacement
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.measure import linearise_at_force
from vegrip.estimator.kernels.motion import begin_motion
from vegrip.estimator.kernels.state import *


def begin_filter(m: Floats, force: float, displacement: float) -> None:
    """Set up the state from the first sample, in the air or in the middle of a contact."""
    clear_section(m, P0, P1)
    clear_section(m, MODE0, MODE1)
    copy_section(m, START0, Y0, N)
    for j in range(N):
        m.p[j * N + j] = m.prior[j]
    m.mode.free_depth = -math.inf
    begin_contact(m, force, displacement)


def begin_contact(m: Floats, force: float, displacement: float) -> None:
    """Begin the motion and the memory at this sample, with the parameters and zeros as they are."""
    if math.isfinite(displacement):
        m.y[DELTA] = displacement - m.y[OFFSET]
        for j in range(N):
            m.p[DELTA * N + j] = m.p[j * N + DELTA] = -m.p[OFFSET * N + j]
        m.p[DELTA * N + DELTA] = m.p[OFFSET * N + OFFSET] + m.set.r_displacement
        begin_motion(m, displacement)
    else:
        m.y[DELTA] = 0.0
        for j in range(N):
            m.p[DELTA * N + j] = m.p[j * N + DELTA] = 0.0
        m.p[DELTA * N + DELTA] = m.prior[DELTA]
        begin_motion(m, m.y[OFFSET])
    m.y[SPEED] = 0.0
    for i in range(NS):
        m.bend_sum[i] = 0.0
        for j in range(N):
            m.p[(EFFECTS + i) * N + j] = m.p[j * N + EFFECTS + i] = 0.0
        m.y[EFFECTS + i] = m.start[EFFECTS + i]
    bound_state(m)
    touching = is_touching(m, force)
    m.mode.zero_known = 0.0 if touching else 1.0
    if touching:
        m.mode.met = 1.0
        set_unknown_history(m, force, displacement)
        if m.mode.blind > 0.0:
            lose_displacement(m)


def is_touching(m: Floats, force: float) -> bool:
    """Whether the force, or without one the indentation, is surely that of a contact."""
    if math.isfinite(force):
        return bool(force - m.y[BIAS] > 4.0 * math.sqrt(m.set.r_force + m.p[BIAS * N + BIAS]))
    return bool(m.y[DELTA] > 4.0 * math.sqrt(m.p[DELTA * N + DELTA]))


def keep_finite(m: Floats) -> None:
    """Whatever came in, no number that is not finite stays: begin anew, in the air, and count it."""
    total = 0.0
    for i in range(Y0, P1):
        total += 0.0 * m[i]
    if total != 0.0 or math.isnan(total):
        m.counts.overflows += 1.0
        contradicted, lost = m.mode.contradicted, m.mode.lost
        begin_filter(m, math.nan, math.nan)
        m.mode.contradicted, m.mode.lost = contradicted, lost


def set_unknown_history(m: Floats, force: float, displacement: float) -> None:
    """The effects may have any history: each state lies evenly between its bounds, and moves with them."""
    copy_state(m)
    if not math.isfinite(displacement):
        linearise_at_force(m, TRIED0, force, 0.0)
        m.y[DELTA] = m.tried[DELTA]
    m.y[DELTA] = max(m.y[DELTA], 0.01 * m.set.depth)
    set_midpoint_states(m, Y0)
    copy_state(m)
    for j in range(M):
        if is_not_effect_state(j):
            h = min(difference_step(m, Y0, j), 1e-3 * m.y[DELTA] if j < EFFECTS else 1e-3)
            m.tried[j] = m.y[j] + h
            set_midpoint_states(m, TRIED0)
            m.tried[j] = m.y[j]
            for i in range(NS):
                m.f[i * N + j] = (m.tried[EFFECTS + i] - m.y[EFFECTS + i]) / h if h > 0.0 else 0.0
    for i in range(NS):
        for c in range(N):
            if is_not_effect_state(c):
                m.p[(EFFECTS + i) * N + c] = m.p[c * N + EFFECTS + i] = covariance_with_state(m, i, c)
    for i in range(NS):
        for k in range(NS):
            spread = midpoint_variance(m, i) if i == k else 0.0
            for j in range(M):
                if is_not_effect_state(j):
                    spread += m.p[(EFFECTS + i) * N + j] * m.f[k * N + j]
            m.p[(EFFECTS + i) * N + EFFECTS + k] = spread


def covariance_with_state(m: Floats, i: int, c: int) -> float:
    """Covariance of effect state ``i`` with coordinate ``c``, by the slopes in F."""
    s = 0.0
    for j in range(M):
        if is_not_effect_state(j):
            s += m.f[i * N + j] * m.p[j * N + c]
    return s


def is_not_effect_state(j: int) -> bool:
    """Whether a coordinate is not an effect state."""
    return j < EFFECTS or j >= LEARNED_FROM


def set_midpoint_states(m: Floats, y: int) -> None:
    """Put every effect state into the middle of what it can be at this indentation."""
    for _ in range(2):  # a bound may rest on another state
        x, elastic_force, force, _ = contact(m, y)
        for j in range(NS):
            if STATE_HIGH[j] != 0:
                low = bounding_quantity(STATE_LOW[j], x, elastic_force, force)
                high = bounding_quantity(STATE_HIGH[j], x, elastic_force, force)
                m[y + EFFECTS + j] = 0.5 * bound_scale(m, j) * (low + high)


def midpoint_variance(m: Floats, j: int) -> float:
    """Variance of an effect state that lies evenly between its bounds."""
    x, elastic_force, force, _ = contact(m, Y0)
    low = bounding_quantity(STATE_LOW[j], x, elastic_force, force)
    width = bound_scale(m, j) * (bounding_quantity(STATE_HIGH[j], x, elastic_force, force) - low)
    return width * width / 12.0


def bound_scale(m: Floats, j: int) -> float:
    """Return the parameter that scales the bounds of effect state ``j``; the contact was looked at before."""
    return m.values[STATE_SHARE[j]] if STATE_SHARE[j] >= 0 else 1.0


def bounding_quantity(code: int, x: float, elastic_force: float, force: float) -> float:
    """Return the quantity a state's bound is named after (the place in ``layout.BOUNDS``)."""
    if code == 1:
        return elastic_force
    if code == 2:
        return force
    return x if code == 3 else 0.0


def keep_belief(m: Floats) -> None:
    """Put aside what is known, before a doubtful sample."""
    copy_section(m, Y0, KEPT_Y0, N)
    copy_section(m, P0, KEPT_P0, N * N)


def return_belief(m: Floats) -> None:
    """Take back what was put aside."""
    copy_section(m, KEPT_Y0, Y0, N)
    copy_section(m, KEPT_P0, P0, N * N)
