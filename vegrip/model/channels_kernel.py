"""A whole recording through the model and the limit surface, one compiled call."""

import math

import numpy as np

from vegrip.contact.limit_surface.fast import gauge, torsion_limit
from vegrip.model.generated import N_OUTSIDE, N_STATES, Floats, advance, readout

ROUNDS = 60  # of the search for an indentation; the Illinois rule needs about eight


def channels(
    values: Floats,
    fresh: Floats,
    t: Floats,
    first: Floats,
    motion: Floats,
    normal: Floats,
    outside: Floats,
    span: Floats,
    out: Floats,
) -> None:
    """Fill the rows of ``out`` (n, 14), see :data:`vegrip.model.channels.QUANTITIES`.

    Args:
        values: parameters, then geometry.
        fresh: states of a recovered contact; NaN where a state outlives an episode.
        t: (n,) [s].
        first: (n,) 1 at the beginning of an episode.
        motion: (n, 2) indentation [m] and speed [m/s]; a NaN indentation is found from the force.
        normal: (n,) measured normal force [N]; NaN takes that of the model.
        outside: (n, N_OUTSIDE), :data:`vegrip.effects.contract.OUTSIDE`.
        span: least and greatest indentation in which to search [m].
        out: receives the quantities.

    """
    n = values.shape[0]
    beside, at, later = n, n + N_OUTSIDE, n + N_OUTSIDE + N_STATES
    m = np.zeros(n + N_OUTSIDE + 2 * N_STATES)
    m[:n] = values
    for j in range(N_STATES):
        m[at + j] = 0.0 if math.isnan(fresh[j]) else fresh[j]
    elastic_force = 0.0
    for i in range(t.shape[0]):
        delta, speed = motion[i, 0], motion[i, 1]
        m[beside:at] = outside[i]
        dt = 0.0
        if first[i] > 0.5:
            if i > 0:
                rest(m, beside, at, t[i] - t[i - 1], fresh)
            elastic_force = 0.0
        else:
            dt = t[i] - t[i - 1]
        if math.isnan(delta):
            delta = depth_of(m, beside, at, later, normal[i], elastic_force, dt, span)
        if first[i] > 0.5:
            elastic_force = advance(m, 0, at, delta, speed, beside, 0.0, 0.0, at)[1]
        x, elastic_force, force, sensed = advance(m, 0, at, delta, speed, beside, elastic_force, dt, at)
        load = force
        if not math.isnan(normal[i]):
            load = max(force + normal[i] - sensed, 0.0)
        a, k, mu = readout(m, 0, at, delta, speed, beside, x, elastic_force, load)
        if force == 0.0:
            a = 0.0  # lifted off, though the imposed indentation may lie above zero
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = delta, x, elastic_force, sensed
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = load, a, k, mu
        slip_load(out[i], load, a, k, mu, outside[i, 1], outside[i, 2])


def rest(m: Floats, beside: int, at: int, pause: float, fresh: Floats) -> None:
    """Let the pause between episodes pass in air; then all recovers but what outlives an episode."""
    advance(m, 0, at, 0.0, 0.0, beside, 0.0, pause, at)
    for j in range(N_STATES):
        if not math.isnan(fresh[j]):
            m[at + j] = fresh[j]


def slip_load(out: Floats, load: float, a: float, k: float, mu: float, f: float, torque: float) -> None:
    """Limits, and where the measured load lies within them: ``gauge(k, f / (mu N), m / (mu N a))``."""
    moment = abs(torque)
    out[8] = mu * load
    out[9] = mu * load * a * torsion_limit(k)
    out[10] = out[11] = out[12] = out[13] = math.nan
    if not (load > 0.0 and a > 0.0 and f + moment > 0.0):
        return
    used = gauge(k, f / (mu * load), moment / (mu * load * a))
    out[10] = used
    out[11] = math.hypot(f, moment / a) / used
    out[12] = f / used
    out[13] = torque / used


def depth_of(
    m: Floats,
    beside: int,
    at: int,
    later: int,
    wanted: float,
    elastic_force: float,
    dt: float,
    span: Floats,
) -> float:
    """Return the indentation [m] at which the model's sensor shows ``wanted`` [N], by the Illinois rule.

    Below the least force that the model can show the surface has lifted off; any indentation in air will do.
    """
    low, high = span[0], span[1]
    f_low = advance(m, 0, at, low, 0.0, beside, elastic_force, dt, later)[3] - wanted
    if not f_low < 0.0:
        return low
    f_high = advance(m, 0, at, high, 0.0, beside, elastic_force, dt, later)[3] - wanted
    if not f_high > 0.0:
        return high
    x, side = low, 0
    for _ in range(ROUNDS):
        x = (f_low * high - f_high * low) / (f_low - f_high)
        f = advance(m, 0, at, x, 0.0, beside, elastic_force, dt, later)[3] - wanted
        if abs(f) <= 1e-12 * abs(wanted) or high - low <= 1e-13 * span[1]:
            break
        if f > 0.0:
            high, f_high = x, f
            f_low = 0.5 * f_low if side == 1 else f_low
            side = 1
        else:
            low, f_low = x, f
            f_high = 0.5 * f_high if side == -1 else f_high
            side = -1
    return x
