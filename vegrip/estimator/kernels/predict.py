"""Prediction: the state after one time step, driven by the measured displacement.

The displacement is the input of the contact: ``delta = displacement - d0 - e``, with an error e that is drawn
anew at every sample. So a drive may do within a sample whatever it likes. Memory and learned parameters move
by statistical linear regression along the roots of the covariance [SarkkaSvensson2023]_: over their whole
spread, not by a slope at their mean, because the product of two unknowns (stiffness and depth, amplitude and
rate) has another slope at every mean, and a filter that collects slopes believes what no sample has said.

Without a displacement the tip goes on at the speed it had (``motion.py``).
"""

import math

from vegrip.estimator.kernels.covariance_root import WIDE, bend_variance, shift_along_root, square_root
from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.state import copy_section, copy_state, propagate, walk_within

STRAIGHT = 0.02  # relative change below which a law is taken for straight over the spread of the state
RESTING = 10.0  # by how much faster a zero may drift once nothing is learned
CROSS = math.sqrt(2.0)  # bends along two columns (amplitude times rate) weigh as much as those along one
FADES = 2.0  # [s] after which an old bend of the memory is forgotten
WITHIN = 0.4  # std of where within a step the motion turned, in steps


def predict(m: Floats, dt: float, displacement: float) -> None:
    """Move state and covariance by ``dt`` [s] to ``displacement`` [m]; NaN: by the speed of the tip."""
    driven = math.isfinite(displacement)
    add_random_walks(m, dt)
    copy_section(m, Y0, OLD0, N)
    m[Y0 + SPEED] = m[MOTION_SPEED]
    square_root(m, P0)
    error = m[SET_R_DISPLACEMENT]
    if not driven:
        error = dt * dt * (m[MOTION_VAR_SPEED] + m[SET_ACCELERATION] * dt / 3.0)
    end = predicted_depth(m, Y0, displacement, dt)
    effects_ahead(m, dt, displacement, math.sqrt(error))
    move_covariance(m, driven)
    add_depth_error(m, error, dt)
    m[Y0 + DELTA] = end
    for i in range(NS):
        m[Y0 + EFFECTS + i] = m[NEXT0 + i]


def predicted_depth(m: Floats, y: int, displacement: float, dt: float) -> float:
    """Indentation [m] at the end of the step, from the state ``y``."""
    if math.isfinite(displacement):
        return float(displacement - m[y + OFFSET])
    return float(m[y + DELTA] + m[MOTION_SPEED] * dt)


def add_random_walks(m: Floats, dt: float) -> None:
    """Random walks of the learned parameters and the zeros, never wider than at the very beginning.

    In a long rest nothing is learned, so what changes then is a zero: both may drift RESTING times as fast.
    """
    rests = m[MODE_REST] > m[SET_LEARNING_REST]
    for j in range(LEARNED_FROM, N):
        faster = RESTING * RESTING if rests and j >= M else 1.0
        walk_within(m, j, faster * m[DRIFT0 + j] * dt, faster * m[PRIOR0 + j])


def effects_ahead(m: Floats, dt: float, displacement: float, error: float) -> None:
    """Effect states after ``dt``: mean in S0, change along L in F, bends in BEND, by ``error`` [m] in H."""
    if NS == 0:
        return
    copy_state(m)
    end = predicted_depth(m, Y0, displacement, dt)
    propagate(m, TRY0, end, m[Y0 + SPEED], dt, NEXT0)
    propagate(m, TRY0, end + error, m[Y0 + SPEED], dt, TRIAL0)
    for i in range(NS):
        m[H0 + i] = m[TRIAL0 + i] - m[NEXT0 + i]
    for i in range(NS):
        m[B0 + i] = 0.0
        m[BEND0 + i] = 0.0
    for j in range(N):
        for i in range(NS):
            m[F0 + i * N + j] = 0.0
        known = (
            LEARNED_FROM <= j < M and m[MODE_BLIND] > 0.5
        )  # parameters without a displacement, see displacement_loss.py
        if j != BIAS and m[L0 + j * N + j] > 0.0 and not known:
            step_along(m, dt, displacement, j)
    for i in range(NS):
        m[NEXT0 + i] += m[B0 + i]


def step_along(m: Floats, dt: float, displacement: float, j: int) -> None:
    """One column of F; where the law bends, also what that adds to mean (B) and variance (BEND)."""
    shift_along_root(m, Y0, j, 1.0)
    propagate(m, TRY0, predicted_depth(m, TRY0, displacement, dt), m[TRY0 + SPEED], dt, TRIAL0)
    straight = True
    for i in range(NS):
        m[F0 + i * N + j] = m[TRIAL0 + i] - m[NEXT0 + i]
        straight = (
            straight and abs(m[NEXT0 + i]) > 0.0 and abs(m[F0 + i * N + j]) <= STRAIGHT * abs(m[NEXT0 + i])
        )
    if straight:
        for i in range(NS):
            m[F0 + i * N + j] /= WIDE
        return
    shift_along_root(m, Y0, j, -1.0)
    propagate(m, TRY0, predicted_depth(m, TRY0, displacement, dt), m[TRY0 + SPEED], dt, TRIAL0)
    for i in range(NS):
        rise, fall = m[F0 + i * N + j], m[NEXT0 + i] - m[TRIAL0 + i]
        m[F0 + i * N + j] = (rise + fall) / (2.0 * WIDE)
        if not KEPT[EFFECTS + i]:
            m[B0 + i] += (rise - fall) / (2.0 * WIDE * WIDE)
            m[BEND0 + i] += bend_variance(rise - fall)


def move_covariance(m: Floats, driven: bool) -> None:
    """``P = A L (A L)'``: the rows of indentation and effects move, those of parameters and zeros stay."""
    for c in range(N):  # B = A L, the rows that move
        m[B0 + DELTA * N + c] = -m[L0 + OFFSET * N + c] if driven else m[L0 + DELTA * N + c]
        for i in range(NS):
            m[B0 + (EFFECTS + i) * N + c] = m[F0 + i * N + c]
    for a in range(LEARNED_FROM):
        if a == SPEED:
            continue
        for b in range(LEARNED_FROM, N):
            s = 0.0
            for c in range(b + 1):  # L is lower triangular
                s += m[B0 + a * N + c] * m[L0 + b * N + c]
            m[P0 + a * N + b] = m[P0 + b * N + a] = s
        for b in range(a, LEARNED_FROM):
            if b != SPEED:
                s = 0.0
                for c in range(N):
                    s += m[B0 + a * N + c] * m[B0 + b * N + c]
                m[P0 + a * N + b] = m[P0 + b * N + a] = s
    for c in range(N):
        m[P0 + SPEED * N + c] = m[P0 + c * N + SPEED] = 0.0
    m[P0 + SPEED * N + SPEED] = m[MOTION_VAR_SPEED]


def add_depth_error(m: Floats, error: float, dt: float) -> None:
    """Add the error of the indentation [m^2], what it does to the memory, and where the motion turned."""
    sd = math.sqrt(error)
    for i in range(NS):
        m[P0 + DELTA * N + EFFECTS + i] += m[H0 + i] * sd
        m[P0 + (EFFECTS + i) * N + DELTA] = m[P0 + DELTA * N + EFFECTS + i]
        for k in range(i, NS):
            m[P0 + (EFFECTS + i) * N + EFFECTS + k] += m[H0 + i] * m[H0 + k]
            m[P0 + (EFFECTS + k) * N + EFFECTS + i] = m[P0 + (EFFECTS + i) * N + EFFECTS + k]
        turned = 0.0 if KEPT[EFFECTS + i] or sd == 0.0 else WITHIN * m[H0 + i] * m[MODE_CORNER] / sd
        m[P0 + (EFFECTS + i) * N + EFFECTS + i] += turned * turned + bend_again(m, i, dt)
    m[P0 + DELTA * N + DELTA] += error


def bend_again(m: Floats, i: int, dt: float) -> float:
    """Variance that the bend of this step adds to effect state ``i``, on top of those before.

    One and the same wrong amplitude and rate bend every step the same way, so what adds up are the standard
    deviations. Added as if they were independent, amplitude and rate came out five times too sure. A state
    that forgets itself forgets its bends as fast.
    """
    bend = CROSS * math.sqrt(m[BEND0 + i])
    j = EFFECTS + i
    own = m[L0 + j * N + j]
    kept = min(max(m[F0 + i * N + j] / own, 0.0), 1.0) if own > 0.0 else 0.0
    before = m[BEND_SUM0 + i] * kept * FADES / (FADES + dt)
    m[BEND_SUM0 + i] = before + bend
    return float(bend * (bend + 2.0 * before))


def follow_extremes(m: Floats, dt: float, driven: bool) -> None:
    """Renew running maxima by the indentation as it is now known, discounted by its noise.

    The maximum of noisy values is not the noisy value of the maximum: of some hundred looks it is 2.5
    standard deviations too large. What the force says of this very sample is in the indentation already.
    """
    kept = False
    for i in range(NS):
        kept = kept or KEPT[EFFECTS + i]
    if not kept or dt <= 0.0:
        return
    noise = indentation_noise(m, driven)
    copy_section(m, OLD0, TRY0, N)
    propagate(m, TRY0, m[Y0 + DELTA] + noise, m[Y0 + SPEED], dt, TRIAL0)
    propagate(m, TRY0, m[Y0 + DELTA], m[Y0 + SPEED], dt, NEXT0)
    for i in range(NS):
        if KEPT[EFFECTS + i]:
            old, discount = m[OLD0 + EFFECTS + i], 2.5 * abs(m[TRIAL0 + i] - m[NEXT0 + i])
            if m[NEXT0 + i] > old:
                m[Y0 + EFFECTS + i] = max(old, m[NEXT0 + i] - discount)
            else:
                m[Y0 + EFFECTS + i] = min(old, m[NEXT0 + i] + discount)


def indentation_noise(m: Floats, driven: bool) -> float:
    """Standard deviation [m] of what the indentation does from sample to sample, without its slow error."""
    if driven:
        seen = 1.0 / m[SET_R_DISPLACEMENT] + m[MODE_SLOPE] * m[MODE_SLOPE] / m[SET_R_FORCE]
        return 1.0 / math.sqrt(seen)
    slow = m[P0 + DELTA * N + BIAS] * m[P0 + DELTA * N + BIAS] / max(m[P0 + BIAS * N + BIAS], 1e-300)
    return math.sqrt(max(m[P0 + DELTA * N + DELTA] - slow, 0.0))
