"""The measured displacement followed on its own, by a filter of constant speed.

It says where the next sample is expected, which only decides when displacement and force contradict each
other, and how fast the tip moves. It is not mixed with the contact: drives start, stop and turn within a
sample, and a contact that is told where the motion should be has to explain the difference.
"""

import math

from vegrip.estimator.kernels.generated import *

LEAST_LEFT = 1e-12  # of a variance, whatever rounding leaves
SUDDEN = 9.0
"""Normalised square of the displacement's innovation at which the motion is taken to have jerked."""


def begin_motion(m: Floats, displacement: float) -> None:
    """Start at rest."""
    m[MOTION_POSITION], m[MOTION_SPEED] = displacement, 0.0
    m[MOTION_VAR_POSITION], m[MOTION_COV] = m[SET_R_DISPLACEMENT], 0.0
    m[MOTION_VAR_SPEED] = m[PRIOR0 + SPEED]
    m[MOTION_RESTLESS] = 1.0


def predict_motion(m: Floats, dt: float) -> None:
    """Go on for ``dt`` [s] at constant speed, disturbed by white acceleration."""
    q = m[SET_ACCELERATION] * m[MOTION_RESTLESS]
    m[MOTION_POSITION] += m[MOTION_SPEED] * dt
    m[MOTION_VAR_POSITION] += dt * (2.0 * m[MOTION_COV] + dt * m[MOTION_VAR_SPEED]) + q * dt * dt * dt / 3.0
    m[MOTION_COV] += dt * m[MOTION_VAR_SPEED] + q * dt * dt / 2.0
    m[MOTION_VAR_SPEED] += q * dt


def surprise_of(m: Floats, displacement: float) -> float:
    """Normalised square of what ``displacement`` [m] differs from the expected one."""
    off = displacement - m[MOTION_POSITION]
    return float(off * off / (m[MOTION_VAR_POSITION] + m[SET_R_DISPLACEMENT]))


def follow_motion(m: Floats, displacement: float, dt: float) -> None:
    """Take in a displacement that is believed; a jerk opens the filter until it explains the sample."""
    off = displacement - m[MOTION_POSITION]
    m[MODE_CORNER] = off
    nis = surprise_of(m, displacement)
    if nis > SUDDEN:
        m[MODE_SINCE_JERK] = 0.0
        if dt > 0.0:
            q = 3.0 * off * off / (dt * dt * dt)
            m[MOTION_VAR_POSITION] += q * dt * dt * dt / 3.0
            m[MOTION_COV] += q * dt * dt / 2.0
            m[MOTION_VAR_SPEED] += q * dt
    S = m[MOTION_VAR_POSITION] + m[SET_R_DISPLACEMENT]
    to_position, to_speed = m[MOTION_VAR_POSITION] / S, m[MOTION_COV] / S
    m[MOTION_POSITION] += to_position * off
    m[MOTION_SPEED] += to_speed * off
    left = m[MOTION_VAR_SPEED] - to_speed * m[MOTION_COV]
    m[MOTION_VAR_SPEED] = max(left, LEAST_LEFT * m[MOTION_VAR_SPEED])
    m[MOTION_COV] *= 1.0 - to_position
    m[MOTION_VAR_POSITION] *= 1.0 - to_position
    adapt_process_noise(m, nis)


def adapt_process_noise(m: Floats, nis: float) -> None:
    """Adapt how restless the motion is taken to be, a factor on the density of the acceleration."""
    calm = m[MOTION_RESTLESS] * (1.0 + 0.03 * (min(nis, 25.0) - 1.0))
    if nis > SUDDEN:
        calm = max(calm, 1.0)
    m[MOTION_RESTLESS] = min(max(calm, 1e-4), 100.0)


def stop_motion(m: Floats, dt: float) -> None:
    """Nothing was heard for ``dt`` [s]: the tip may be anywhere, at any speed."""
    m[MOTION_SPEED] = m[MOTION_COV] = 0.0
    m[MOTION_VAR_SPEED] = m[PRIOR0 + SPEED]
    m[MOTION_VAR_POSITION] = math.inf if math.isinf(dt) else m[PRIOR0 + DELTA]
