"""Whether what is published agrees with what was just measured."""

import math

from vegrip.estimator.kernels.generated import (
    BIAS,
    MODE_CONTRADICTED,
    MODE_LOST,
    REP_DEPTH_NOW,
    REP_DEPTH_STD,
    REP_FORCE,
    REP_FORCE_STD,
    REP_RADIUS,
    REP_RADIUS_STD,
    REP_SOUND,
    SET_R_DISPLACEMENT,
    SET_R_RADIUS,
    Y0,
    ZERO,
    Floats,
)

FAR = 25.0
"""Square of the standard deviations by which an estimate may differ from its own measurement, and"""
PATIENCE = 0.015
"""[s] for which it may do so before it is valid no longer: two samples at 100 Hz."""


def contradicted(m: Floats, dt: float, force: float, displacement: float, radius: float) -> None:
    """Note for how long an estimate has disagreed with its own measurement; it is not sound for longer."""
    far = False
    if math.isfinite(force):
        far = (force - m[REP_FORCE] - m[Y0 + BIAS]) ** 2 > FAR * m[REP_FORCE_STD] ** 2
    if math.isfinite(displacement):
        off = displacement - m[REP_DEPTH_NOW] - m[Y0 + ZERO]
        far = far or off * off > FAR * (m[REP_DEPTH_STD] ** 2 + m[SET_R_DISPLACEMENT])
    if math.isfinite(radius) and radius > 0.0 and m[REP_RADIUS] > 0.0:
        off = radius - m[REP_RADIUS]
        far = far or off * off > FAR * (m[REP_RADIUS_STD] ** 2 + m[SET_R_RADIUS])
    if not far:
        m[MODE_CONTRADICTED] = 0.0
    elif m[MODE_CONTRADICTED] == 0.0:
        m[MODE_CONTRADICTED] = 1e-9
    else:
        m[MODE_CONTRADICTED] += dt
    if m[MODE_CONTRADICTED] > PATIENCE or m[MODE_LOST] > PATIENCE:
        m[REP_SOUND] = 0.0
