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
    asked: Floats,
    out: Floats,
) -> None:
    """Fill the rows of ``out`` (n, 14), see :data:`vegrip.model.channels.QUANTITIES`.

    Args:
        values: parameters, then geometry.
        fresh: (2, N_STATES) states of a recovered contact; 1 where a state outlives an episode.
        t: (n,) [s].
        first: (n,) 1 at the beginning of an episode.
        motion: (n, 2) indentation [m] and speed [m/s].
        normal: (n,) measured normal force [N]; NaN takes that of the model.
        outside: (n, N_OUTSIDE), :data:`vegrip.effects.contract.OUTSIDE`.
        asked: (n,) 2 for all quantities, 1 for none of the friction channels, 0 for none of the patch either.
        out: receives the quantities; NaN where they are not asked for.

    """
    m = memory(values, fresh)
    beside = values.shape[0]
    at = beside + N_OUTSIDE
    elastic_force = 0.0
    for i in range(t.shape[0]):
        delta, speed = motion[i, 0], motion[i, 1]
        dt = elapsed(m, fresh, t, first, i)
        for j in range(N_OUTSIDE):
            m[beside + j] = outside[i, j]
        x, elastic_force, force, sensed = advance(m, 0, at, delta, speed, beside, elastic_force, dt, at)
        load = force
        if not math.isnan(normal[i]):
            load = max(force + normal[i] - sensed, 0.0)
        a = k = mu = math.nan
        if asked[i] > 0.5:
            a, k, mu = readout(m, 0, at, delta, speed, beside, x, elastic_force, load)
        if force == 0.0:
            a = 0.0  # lifted off, though the imposed indentation may lie above zero
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = delta, x, elastic_force, sensed
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = load, a, k, mu
        if asked[i] > 1.5:
            slip_load(out, i, load, a, k, mu, outside[i, 1], outside[i, 2])
        else:
            for j in range(8, 14):
                out[i, j] = math.nan


def depths(
    values: Floats,
    fresh: Floats,
    t: Floats,
    first: Floats,
    motion: Floats,
    normal: Floats,
    outside: Floats,
    span: Floats,
) -> None:
    """Put indentations in place of the NaN in ``motion``: those that give the ``normal`` force on the sensor.

    ``span``: least and greatest indentation in which to search [m]; the rest as for :func:`channels`.
    """
    m = memory(values, fresh)
    beside = values.shape[0]
    at = beside + N_OUTSIDE
    elastic_force = 0.0
    for i in range(t.shape[0]):
        dt = elapsed(m, fresh, t, first, i)
        for j in range(N_OUTSIDE):
            m[beside + j] = outside[i, j]
        if math.isnan(motion[i, 0]):
            motion[i, 0] = depth_of(m, beside, at, normal[i], elastic_force, dt, span)
        step = advance(m, 0, at, motion[i, 0], motion[i, 1], beside, elastic_force, dt, at)
        elastic_force = step[1]


def memory(values: Floats, fresh: Floats) -> Floats:
    """Return the array that ``advance`` works on: values, outside, states, room for states on trial."""
    n, at = values.shape[0], values.shape[0] + N_OUTSIDE
    m = np.zeros(at + 2 * N_STATES)
    for j in range(n):  # loops: slices take the compiler twice as long
        m[j] = values[j]
    for j in range(N_STATES):
        m[at + j] = fresh[0, j]
    return m


def elapsed(m: Floats, fresh: Floats, t: Floats, first: Floats, i: int) -> float:
    """Return the time since the last sample [s], 0 at the beginning of an episode, whose pause passes in air.

    After the pause all has recovered but what outlives an episode.
    """
    if first[i] < 0.5:
        return float(t[i] - t[i - 1])
    beside, at = m.shape[0] - 2 * N_STATES - N_OUTSIDE, m.shape[0] - 2 * N_STATES
    if i > 0:
        advance(m, 0, at, 0.0, 0.0, beside, 0.0, t[i] - t[i - 1], at)
    for j in range(N_STATES):
        if fresh[1, j] < 0.5:
            m[at + j] = fresh[0, j]
    return 0.0


def slip_load(
    out: Floats, i: int, load: float, a: float, k: float, mu: float, f: float, torque: float
) -> None:
    """Limits, and where the measured load lies within them: ``gauge(k, f / (mu N), m / (mu N a))``."""
    moment = abs(torque)
    out[i, 8] = mu * load
    out[i, 9] = mu * load * a * torsion_limit(k)
    out[i, 10] = out[i, 11] = out[i, 12] = out[i, 13] = math.nan
    if not (load > 0.0 and a > 0.0 and f + moment > 0.0):
        return
    used = gauge(k, f / (mu * load), moment / (mu * load * a))
    out[i, 10] = used
    out[i, 11] = math.hypot(f, moment / a) / used
    out[i, 12] = f / used
    out[i, 13] = torque / used


def depth_of(
    m: Floats, beside: int, at: int, wanted: float, elastic_force: float, dt: float, span: Floats
) -> float:
    """Return the indentation [m] at which the model's sensor shows ``wanted`` [N], by the Illinois rule.

    Below the least force that the model can show the surface has lifted off; any indentation in air will do.
    """
    trial = at + N_STATES
    low, high, x = float(span[0]), float(span[1]), float(span[0])
    f_low = f_high = 0.0
    side = 0
    for i in range(ROUNDS):
        if i == 1:
            x = high
        elif i > 1:
            x = (f_low * high - f_high * low) / (f_low - f_high)
        f = advance(m, 0, at, x, 0.0, beside, elastic_force, dt, trial)[3] - wanted
        if i == 0:
            f_low = f
            if not f < 0.0:
                return low
        elif i == 1:
            f_high = f
            if not f > 0.0:
                return high
        elif abs(f) <= 1e-12 * abs(wanted) or high - low <= 1e-13 * span[1]:
            return x
        elif f > 0.0:
            high, f_high = x, f
            f_low = 0.5 * f_low if side == 1 else f_low
            side = 1
        else:
            low, f_low = x, f
            f_high = 0.5 * f_high if side == -1 else f_high
            side = -1
    return x
