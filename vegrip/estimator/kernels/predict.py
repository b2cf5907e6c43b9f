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
    m.y[SPEED] = m.motion.speed
    square_root(m, P0)
    error = m.set.r_displacement
    if not driven:
        error = dt * dt * (m.motion.var_speed + m.set.acceleration * dt / 3.0)
    end = predicted_depth(m, Y0, displacement, dt)
    effects_ahead(m, dt, displacement, math.sqrt(error))
    move_covariance(m, driven)
    add_depth_error(m, error, dt)
    m.y[DELTA] = end
    for i in range(NS):
        m.y[EFFECTS + i] = m.next[i]


def predicted_depth(m: Floats, y: int, displacement: float, dt: float) -> float:
    """Indentation [m] at the end of the step, from the state ``y``."""
    if math.isfinite(displacement):
        return float(displacement - m[y + OFFSET])
    return float(m[y + DELTA] + m.motion.speed * dt)


def add_random_walks(m: Floats, dt: float) -> None:
    """Random walks of the learned parameters and the zeros, never wider than at the very beginning.

    In a long rest nothing is learned, so what changes then is a zero: both may drift RESTING times as fast.
    """
    rests = m.mode.rest > m.set.learning_rest
    for j in range(LEARNED_FROM, N):
        faster = RESTING * RESTING if rests and j >= M else 1.0
        walk_within(m, j, faster * m.drift[j] * dt, faster * m.prior[j])


def effects_ahead(m: Floats, dt: float, displacement: float, error: float) -> None:
    """Effect states after ``dt``: mean in S0, change along L in F, bends in BEND, by ``error`` [m] in H."""
    if NS == 0:
        return
    copy_state(m)
    end = predicted_depth(m, Y0, displacement, dt)
    propagate(m, TRIED0, end, m.y[SPEED], dt, NEXT0)
    propagate(m, TRIED0, end + error, m.y[SPEED], dt, TRIAL0)
    for i in range(NS):
        m.h[i] = m.trial[i] - m.next[i]
    for i in range(NS):
        m.b[i] = 0.0
        m.bend[i] = 0.0
    for j in range(N):
        for i in range(NS):
            m.f[i * N + j] = 0.0
        known = (
            LEARNED_FROM <= j < M and m.mode.blind > 0.0
        )  # parameters without a displacement, see displacement_loss.py
        if j != BIAS and m.l[j * N + j] > 0.0 and not known:
            step_along(m, dt, displacement, j)
    for i in range(NS):
        m.next[i] += m.b[i]


def step_along(m: Floats, dt: float, displacement: float, j: int) -> None:
    """One column of F; where the law bends, also what that adds to mean (B) and variance (BEND)."""
    shift_along_root(m, Y0, j, 1.0)
    propagate(m, TRIED0, predicted_depth(m, TRIED0, displacement, dt), m.tried[SPEED], dt, TRIAL0)
    straight = True
    for i in range(NS):
        m.f[i * N + j] = m.trial[i] - m.next[i]
        straight = straight and abs(m.next[i]) > 0.0 and abs(m.f[i * N + j]) <= STRAIGHT * abs(m.next[i])
    if straight:
        for i in range(NS):
            m.f[i * N + j] /= WIDE
        return
    shift_along_root(m, Y0, j, -1.0)
    propagate(m, TRIED0, predicted_depth(m, TRIED0, displacement, dt), m.tried[SPEED], dt, TRIAL0)
    for i in range(NS):
        rise, fall = m.f[i * N + j], m.next[i] - m.trial[i]
        m.f[i * N + j] = (rise + fall) / (2.0 * WIDE)
        if not KEPT[EFFECTS + i]:
            m.b[i] += (rise - fall) / (2.0 * WIDE * WIDE)
            m.bend[i] += bend_variance(rise - fall)


def move_covariance(m: Floats, driven: bool) -> None:
    """``P = A L (A L)'``: the rows of indentation and effects move, those of parameters and zeros stay."""
    for c in range(N):  # B = A L, the rows that move
        m.b[DELTA * N + c] = -m.l[OFFSET * N + c] if driven else m.l[DELTA * N + c]
        for i in range(NS):
            m.b[(EFFECTS + i) * N + c] = m.f[i * N + c]
    for a in range(LEARNED_FROM):
        if a == SPEED:
            continue
        for b in range(LEARNED_FROM, N):
            s = 0.0
            for c in range(b + 1):  # L is lower triangular
                s += m.b[a * N + c] * m.l[b * N + c]
            m.p[a * N + b] = m.p[b * N + a] = s
        for b in range(a, LEARNED_FROM):
            if b != SPEED:
                s = 0.0
                for c in range(N):
                    s += m.b[a * N + c] * m.b[b * N + c]
                m.p[a * N + b] = m.p[b * N + a] = s
    for c in range(N):
        m.p[SPEED * N + c] = m.p[c * N + SPEED] = 0.0
    m.p[SPEED * N + SPEED] = m.motion.var_speed


def add_depth_error(m: Floats, error: float, dt: float) -> None:
    """Add the error of the indentation [m^2], what it does to the memory, and where the motion turned."""
    sd = math.sqrt(error)
    for i in range(NS):
        m.p[DELTA * N + EFFECTS + i] += m.h[i] * sd
        m.p[(EFFECTS + i) * N + DELTA] = m.p[DELTA * N + EFFECTS + i]
        for k in range(i, NS):
            m.p[(EFFECTS + i) * N + EFFECTS + k] += m.h[i] * m.h[k]
            m.p[(EFFECTS + k) * N + EFFECTS + i] = m.p[(EFFECTS + i) * N + EFFECTS + k]
        turned = 0.0 if KEPT[EFFECTS + i] or sd == 0.0 else WITHIN * m.h[i] * m.mode.corner / sd
        m.p[(EFFECTS + i) * N + EFFECTS + i] += turned * turned + bend_again(m, i, dt)
    m.p[DELTA * N + DELTA] += error


def bend_again(m: Floats, i: int, dt: float) -> float:
    """Variance that the bend of this step adds to effect state ``i``, on top of those before.

    One and the same wrong amplitude and rate bend every step the same way, so what adds up are the standard
    deviations. Added as if they were independent, amplitude and rate came out five times too sure. A state
    that forgets itself forgets its bends as fast.
    """
    bend = CROSS * math.sqrt(m.bend[i])
    j = EFFECTS + i
    own = m.l[j * N + j]
    kept = min(max(m.f[i * N + j] / own, 0.0), 1.0) if own > 0.0 else 0.0
    before = m.bend_sum[i] * kept * FADES / (FADES + dt)
    m.bend_sum[i] = before + bend
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
    copy_section(m, OLD0, TRIED0, N)
    propagate(m, TRIED0, m.y[DELTA] + noise, m.y[SPEED], dt, TRIAL0)
    propagate(m, TRIED0, m.y[DELTA], m.y[SPEED], dt, NEXT0)
    for i in range(NS):
        if KEPT[EFFECTS + i]:
            old, discount = m.old[EFFECTS + i], 2.5 * abs(m.trial[i] - m.next[i])
            if m.next[i] > old:
                m.y[EFFECTS + i] = max(old, m.next[i] - discount)
            else:
                m.y[EFFECTS + i] = min(old, m.next[i] + discount)


def indentation_noise(m: Floats, driven: bool) -> float:
    """Standard deviation [m] of what the indentation does from sample to sample, without its slow error."""
    if driven:
        seen = 1.0 / m.set.r_displacement + m.mode.slope * m.mode.slope / m.set.r_force
        return 1.0 / math.sqrt(seen)
    slow = m.p[DELTA * N + BIAS] * m.p[DELTA * N + BIAS] / max(m.p[BIAS * N + BIAS], 1e-300)
    return math.sqrt(max(m.p[DELTA * N + DELTA] - slow, 0.0))
