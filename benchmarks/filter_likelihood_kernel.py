"""The likelihood of the node's own filter over a recording, one compiled call."""

import math

from vegrip.estimator.kernels.generated import (
    MODE_CORNER,
    MODE_ZERO_KNOWN,
    MOTION_POSITION,
    REP_CONTACT,
    SET_R_FORCE,
    Y0,
    Floats,
)
from vegrip.estimator.kernels.initialisation import begin_filter
from vegrip.estimator.kernels.measure import expect_force
from vegrip.estimator.kernels.motion import follow_motion, predict_motion
from vegrip.estimator.kernels.predict import follow_extremes, predict
from vegrip.estimator.kernels.scalar_update import apply_measurement
from vegrip.estimator.kernels.state import bound_state, contact
from vegrip.estimator.kernels.update import note_regime


def likelihood(m: Floats, blank: Floats, t: Floats, first: Floats, y: Floats, out: Floats) -> None:
    """Put into ``out`` nothing for the displacement, which drives the filter, and the force's log-likelihood.

    The filter is that of the node, gates included: an innovation counts with at most ten standard
    deviations. ``y`` (n, 2): displacement [m] and force [N]; every episode begins anew.
    """
    out[0] = out[1] = 0.0
    for i in range(t.shape[0]):
        dt = 0.0
        if first[i] > 0.5:
            for j in range(m.shape[0]):
                m[j] = blank[j]
            begin_filter(m, y[i, 1], y[i, 0])
        else:
            dt = t[i] - t[i - 1]
        predict_motion(m, dt)
        note_regime(m, dt)
        m[MODE_CORNER] = y[i, 0] - m[MOTION_POSITION]
        predict(m, dt, y[i, 0])
        bound_state(m)
        innovation, S = expect_force(m, y[i, 1])
        out[1] -= 0.5 * (min(innovation * innovation / S, 100.0) + math.log(S))
        apply_measurement(m, 1, innovation, S)
        follow_motion(m, y[i, 0], dt)
        follow_extremes(m, dt, True)
        force = contact(m, Y0)[2]
        if force <= 0.0:
            m[MODE_ZERO_KNOWN] = 1.0
        m[REP_CONTACT] = 1.0 if force > 2.0 * math.sqrt(m[SET_R_FORCE]) else 0.0
