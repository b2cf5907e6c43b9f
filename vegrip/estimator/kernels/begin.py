"""The first sample, and starting over after too many refusals: states of nothing known."""

import math

from vegrip.estimator.kernels.generated import (
    F0,
    LOAD0,
    LOST0,
    NS,
    P0,
    P1,
    PRIOR0,
    SET_DEPTH,
    SET_R_DISPLACEMENT,
    SET_R_FORCE,
    START0,
    STATE_HIGH,
    STATE_LOW,
    TRY0,
    Y0,
    Floats,
    M,
    N,
)
from vegrip.estimator.kernels.measure import meet
from vegrip.estimator.kernels.state import bound, clear, contact, copy_state, step_of


def begin(m: Floats, force: float, displacement: float) -> None:
    """Set up the state from the first sample, in the air or in the middle of a contact."""
    clear(m, P0, P1)
    for j in range(N):
        m[Y0 + j] = m[START0 + j]
    m[Y0] = displacement if math.isfinite(displacement) else 0.0
    bound(m)
    for j in range(N):
        m[P0 + j * N + j] = m[PRIOR0 + j]
    touching = m[Y0] > 4.0 * math.sqrt(m[SET_R_DISPLACEMENT] + m[PRIOR0 + N - 2])
    if math.isfinite(force):
        touching = force > 4.0 * math.sqrt(m[SET_R_FORCE] + m[PRIOR0 + N - 1])
    m[LOAD0] = 0.0 if touching else 1.0
    if touching:
        within_contact(m, force, displacement)


def keep_finite(m: Floats) -> None:
    """Whatever came in, no number that is not finite stays: begin anew, in the air, and count it."""
    total = 0.0
    for i in range(Y0, P1):
        total += 0.0 * m[i]
    if total != 0.0 or math.isnan(total):
        m[LOST0] += 1.0
        begin(m, math.nan, math.nan)


def within_contact(m: Floats, force: float, displacement: float) -> None:
    """The effects may have any history: each state lies evenly between its bounds, and moves with them."""
    copy_state(m)
    if not math.isfinite(displacement):
        meet(m, TRY0, force, 0.0)
        m[Y0] = m[TRY0]
    m[Y0] = max(m[Y0], 0.01 * m[SET_DEPTH])
    settle(m, Y0)
    copy_state(m)
    for j in range(M):
        if foreign(j):
            h = min(step_of(m, Y0, j), 1e-3 * m[Y0] if j < 2 else 1e-3)
            m[TRY0 + j] = m[Y0 + j] + h
            settle(m, TRY0)
            m[TRY0 + j] = m[Y0 + j]
            for i in range(NS):
                m[F0 + i * M + j] = (m[TRY0 + 2 + i] - m[Y0 + 2 + i]) / h if h > 0.0 else 0.0
    for i in range(NS):
        for j in range(M):
            if foreign(j):
                m[P0 + (2 + i) * N + j] = m[F0 + i * M + j] * m[P0 + j * N + j]
                m[P0 + j * N + 2 + i] = m[P0 + (2 + i) * N + j]
        for k in range(NS):
            s = settled_spread(m, i) if i == k else 0.0
            for j in range(M):
                if foreign(j):
                    s += m[F0 + i * M + j] * m[P0 + j * N + j] * m[F0 + k * M + j]
            m[P0 + (2 + i) * N + 2 + k] = s


def foreign(j: int) -> bool:
    """Whether a coordinate is not an effect state."""
    return j < 2 or j >= 2 + NS


def settle(m: Floats, y: int) -> None:
    """Put every effect state into the middle of what it can be at this indentation."""
    for _ in range(2):  # a bound may rest on another state
        x, elastic_force, force, _ = contact(m, y)
        for j in range(NS):
            if STATE_HIGH[j] != 0:
                low = named(STATE_LOW[j], x, elastic_force, force)
                m[y + 2 + j] = 0.5 * (low + named(STATE_HIGH[j], x, elastic_force, force))


def settled_spread(m: Floats, j: int) -> float:
    """Variance of an effect state that lies evenly between its bounds."""
    x, elastic_force, force, _ = contact(m, Y0)
    low = named(STATE_LOW[j], x, elastic_force, force)
    width = named(STATE_HIGH[j], x, elastic_force, force) - low
    return width * width / 12.0


def named(code: int, x: float, elastic_force: float, force: float) -> float:
    """Return the quantity a state's bound is named after (the place in ``layout.BOUNDS``)."""
    if code == 1:
        return elastic_force
    if code == 2:
        return force
    return x if code == 3 else 0.0


def widen(m: Floats, from_displacement: bool, displacement: float) -> None:
    """After many refusals in a row: the motion and the memory are unknown again, what is learned wide."""
    if from_displacement:
        m[Y0] = displacement - m[Y0 + N - 2]
        m[Y0 + 1] = 0.0
    for j in range(N):
        m[P0 + j * N + j] += m[PRIOR0 + j]
    for j in range(NS):
        m[P0 + (2 + j) * N + 2 + j] += settled_spread(m, j)
