"""The measured displacement followed on its own, by a filter of constant speed.

It says where the next sample is expected, which only decides when displacement and force contradict each
other, and how fast the tip moves. It is not mixed with the contact: drives start, stop and turn within a
sample, and a contact that is told where the motion should be has to explain the difference.
"""

from vegrip.estimator.kernels.generated import *

LEAST_LEFT = 1e-12  # of a variance, whatever rounding leaves
SUDDEN = 9.0
"""Normalised square of the displacement's innovation at which the motion is taken to have jerked."""


def begin_motion(m: Floats, displacement: float) -> None:
    """Start at rest."""
    m.motion.position, m.motion.speed = displacement, 0.0
    m.motion.var_position, m.motion.cov = m.set.r_displacement, 0.0
    m.motion.var_speed = m.prior[SPEED]
    m.motion.restless = 1.0


def predict_motion(m: Floats, dt: float) -> None:
    """Go on for ``dt`` [s] at constant speed, disturbed by white acceleration."""
    q = m.set.acceleration * m.motion.restless
    m.motion.position += m.motion.speed * dt
    m.motion.var_position += dt * (2.0 * m.motion.cov + dt * m.motion.var_speed) + q * dt * dt * dt / 3.0
    m.motion.cov += dt * m.motion.var_speed + q * dt * dt / 2.0
    m.motion.var_speed += q * dt


def surprise_of(m: Floats, displacement: float) -> float:
    """Normalised square of what ``displacement`` [m] differs from the expected one."""
    off = displacement - m.motion.position
    return float(off * off / (m.motion.var_position + m.set.r_displacement))


def follow_motion(m: Floats, displacement: float, dt: float) -> None:
    """Take in a displacement that is believed; a jerk opens the filter until it explains the sample."""
    off = displacement - m.motion.position
    m.mode.corner = off
    nis = surprise_of(m, displacement)
    if nis > SUDDEN:
        m.mode.since_jerk = 0.0
        if dt > 0.0:
            q = 3.0 * off * off / (dt * dt * dt)
            m.motion.var_position += q * dt * dt * dt / 3.0
            m.motion.cov += q * dt * dt / 2.0
            m.motion.var_speed += q * dt
    S = m.motion.var_position + m.set.r_displacement
    to_position, to_speed = m.motion.var_position / S, m.motion.cov / S
    m.motion.position += to_position * off
    m.motion.speed += to_speed * off
    left = m.motion.var_speed - to_speed * m.motion.cov
    m.motion.var_speed = max(left, LEAST_LEFT * m.motion.var_speed)
    m.motion.cov *= 1.0 - to_position
    m.motion.var_position *= 1.0 - to_position
    adapt_process_noise(m, nis)


def adapt_process_noise(m: Floats, nis: float) -> None:
    """Adapt how restless the motion is taken to be, a factor on the density of the acceleration."""
    calm = m.motion.restless * (1.0 + 0.03 * (min(nis, 25.0) - 1.0))
    if nis > SUDDEN:
        calm = max(calm, 1.0)
    m.motion.restless = min(max(calm, 1e-4), 100.0)
