"""The likelihood of the node's own filter over a recording, one compiled call."""

import math

from vegrip.estimator.kernels.begin import begin
from vegrip.estimator.kernels.gain import regime_of
from vegrip.estimator.kernels.generated import (
    G0,
    H0,
    HEALTH0,
    HEALTH1,
    LOAD0,
    REP_CONTACT,
    SET_R_DISPLACEMENT,
    SET_R_FORCE,
    SIZE,
    Y0,
    Floats,
    N,
)
from vegrip.estimator.kernels.measure import measure_displacement, measure_force
from vegrip.estimator.kernels.predict import predict
from vegrip.estimator.kernels.sight import look
from vegrip.estimator.kernels.state import bound, contact


def likelihood(m: Floats, blank: Floats, t: Floats, first: Floats, y: Floats, out: Floats) -> None:
    """Put into ``out`` the log-likelihoods of displacement and force, and the greatest that one row costs.

    The filter is that of the node, gates and adaptive motion included: an innovation counts with at most ten
    standard deviations. ``y`` (n, 2): displacement [m] and force [N]; every episode begins anew.
    """
    out[0] = out[1] = 0.0
    for i in range(t.shape[0]):
        dt = 0.0
        if first[i] > 0.5:
            for j in range(SIZE):
                m[j] = blank[j]
            begin(m, y[i, 1], y[i, 0])
            m[LOAD0 + 2] = 0.0  # remember the last innovation only
        else:
            dt = t[i] - t[i - 1]
        look(m, False)
        predict(m, dt, 1.0)
        m[LOAD0 + 3] = regime_of(m)
        bound(m)
        measure_displacement(m, y[i, 0])
        out[0] -= 0.5 * cost(m, 0, m[SET_R_DISPLACEMENT])
        measure_force(m, y[i, 1], False)
        out[1] -= 0.5 * cost(m, 1, m[SET_R_FORCE])
        force = contact(m, Y0)[2]
        if force <= 0.0:
            m[LOAD0] = 1.0
        m[REP_CONTACT] = 1.0 if force > 2.0 * math.sqrt(m[SET_R_FORCE]) else 0.0


def cost(m: Floats, channel: int, R: float) -> float:
    """``nu^2 / S + ln S`` of the last measurement; S from its gradient H and from G = P H."""
    S = R
    for j in range(N):
        S += m[H0 + j] * m[G0 + j]
    at = HEALTH0 + (HEALTH1 - HEALTH0) // 3 * channel + 3 * int(m[LOAD0 + 5])
    return float(m[at + 2] + math.log(S))
