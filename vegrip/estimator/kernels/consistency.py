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
        off = force - m[REP_FORCE] - m[Y0 + BIAS]
        far = off * off > FAR * (m[REP_FORCE_STD] * m[REP_FORCE_STD])
    if math.isfinite(displacement):
        off = displacement - m[REP_DEPTH_NOW] - m[Y0 + OFFSET]
        far = far or off * off > FAR * (m[REP_DEPTH_STD] * m[REP_DEPTH_STD] + m[SET_R_DISPLACEMENT])
    m[MODE_CONTRADICTED] = duration_of(m[MODE_CONTRADICTED], dt, far)
    if m[MODE_CONTRADICTED] > PATIENCE or m[MODE_LOST] > PATIENCE:
        m[REP_SOUND] = 0.0
    far = False
    if math.isfinite(radius) and radius > 0.0 and m[REP_RADIUS] > 0.0:
        off = radius - m[REP_RADIUS]
        far = off * off > FAR * (m[REP_RADIUS_STD] * m[REP_RADIUS_STD] + m[SET_R_RADIUS])
    m[MODE_RADIUS_CONTRADICTED] = duration_of(m[MODE_RADIUS_CONTRADICTED], dt, far)
    m[REP_RADIUS_SOUND] = 0.0 if m[MODE_RADIUS_CONTRADICTED] > PATIENCE else m[REP_SOUND]


def duration_of(before: float, dt: float, far: bool) -> float:
    """For how long [s] it has lasted; the first sample begins it."""
    if not far:
        return 0.0
    return before + dt if before > 0.0 else 1e-9
