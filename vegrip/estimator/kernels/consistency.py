"""Whether what is published agrees with what was just measured."""

import math

from vegrip.estimator.kernels.generated import *

FAR = 25.0
"""Square of the standard deviations by which an estimate may differ from its own measurement, and"""
PATIENCE = 0.015
"""[s] for which it may do so before it is valid no longer: two samples at 100 Hz."""


def note_contradiction(m: Floats, dt: float, force: float, displacement: float, radius: float) -> None:
    """Note for how long an estimate has disagreed with its own measurement; it is not sound for longer.

    A force or a displacement that disagrees concerns all estimates, a radius only itself: its law may be
    wrong.
    """
    far = False
    if math.isfinite(force):
        off = force - m.report.force - m.y[BIAS]
        far = off * off > FAR * (m.report.force_std * m.report.force_std)
    if math.isfinite(displacement):
        off = displacement - m.report.depth_now - m.y[OFFSET]
        far = far or off * off > FAR * (m.report.depth_std * m.report.depth_std + m.set.r_displacement)
    m.mode.contradicted = duration_of(m.mode.contradicted, dt, far)
    if m.mode.contradicted > PATIENCE or m.mode.lost > PATIENCE:
        m.report.sound = 0.0
    far = False
    if math.isfinite(radius) and radius > 0.0 and m.report.radius > 0.0:
        off = radius - m.report.radius
        far = off * off > FAR * (m.report.radius_std * m.report.radius_std + m.set.r_radius)
    m.mode.radius_contradicted = duration_of(m.mode.radius_contradicted, dt, far)
    m.report.radius_sound = 0.0 if m.mode.radius_contradicted > PATIENCE else m.report.sound


def duration_of(before: float, dt: float, far: bool) -> float:
    """For how long [s] it has lasted; the first sample begins it."""
    if not far:
        return 0.0
    return before + dt if before > 0.0 else 1e-9
