"""A whole recording through the model and the limit surface, one compiled call."""

import math

from vegrip.contact.limit_surface.fast import gauge, torsion_limit
from vegrip.model.generated import (
    N_GEOMETRY,
    N_OUTSIDE,
    N_STATES,
    N_VALUES,
    Floats,
    advance,
    read_radius,
    readout,
)

ROUNDS = 60  # of the search for an indentation; the Illinois rule needs about eight
GIVEN = N_VALUES + N_GEOMETRY  # places in the room for one step: values, outside, states, states on trial
NOW = GIVEN + N_OUTSIDE
COLUMNS = 14  # of :data:`vegrip.model.channels.QUANTITIES`


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
    m: Floats,
    n: int,
) -> None:
    """Fill ``out`` (14, n), see :data:`vegrip.model.channels.QUANTITIES`; arrays are flat.

    Args:
        values: parameters, then geometry.
        fresh: (2, N_STATES) states of a recovered contact; 1 where a state outlives an episode.
        t: (n,) [s].
        first: (n,) 1 at the beginning of an episode.
        motion: (n, 2) indentation [m] and speed [m/s].
        normal: (n,) measured normal force [N]; NaN takes that of the model.
        outside: (n, N_OUTSIDE), :data:`vegrip.effects.contract.OUTSIDE`.
        asked: (n,) 2 for all quantities, 1 for none after the contact radius, 0 for that neither.
        out: receives the quantities; NaN where they are not asked for.
        m: room for one step.
        n: number of rows.

    """
    begin(m, values, fresh)
    elastic_force = 0.0
    for i in range(n):
        delta, speed = motion[2 * i], motion[2 * i + 1]
        dt = elapsed(m, fresh, t, first, i)
        for j in range(N_OUTSIDE):
            m[GIVEN + j] = outside[N_OUTSIDE * i + j]
        x, elastic_force, force, sensed = advance(m, 0, NOW, delta, speed, GIVEN, elastic_force, dt, NOW)
        load = force
        if not math.isnan(normal[i]):
            load = max(force + normal[i] - sensed, 0.0)
        a = k = mu = math.nan
        if asked[i] > 1.5:
            a, k, mu = readout(m, 0, NOW, delta, speed, GIVEN, x, elastic_force, load)
        elif asked[i] > 0.5:
            a = read_radius(m, 0, NOW, delta, speed, GIVEN, x, elastic_force, load)
        if force == 0.0:
            a = 0.0  # lifted off, though the imposed indentation may lie above zero
        out[i], out[n + i], out[2 * n + i], out[3 * n + i] = delta, x, elastic_force, sensed
        out[4 * n + i], out[5 * n + i], out[6 * n + i], out[7 * n + i] = load, a, k, mu
        if asked[i] > 1.5:
            slip_load(out, i, n, load, a, k, mu, outside[N_OUTSIDE * i + 1], outside[N_OUTSIDE * i + 2])
        else:
            for j in range(8, COLUMNS):
                out[j * n + i] = math.nan


def depths(
    values: Floats,
    fresh: Floats,
    t: Floats,
    first: Floats,
    motion: Floats,
    normal: Floats,
    outside: Floats,
    span: Floats,
    m: Floats,
    n: int,
) -> None:
    """Put indentations in place of the NaN in ``motion``: those that give the ``normal`` force on the sensor.

    ``span``: least and greatest indentation in which to search [m]; the rest as for :func:`channels`.
    """
    begin(m, values, fresh)
    elastic_force = 0.0
    for i in range(n):
        dt = elapsed(m, fresh, t, first, i)
        for j in range(N_OUTSIDE):
            m[GIVEN + j] = outside[N_OUTSIDE * i + j]
        if math.isnan(motion[2 * i]):
            motion[2 * i] = depth_of(m, normal[i], elastic_force, dt, span)
        step = advance(m, 0, NOW, motion[2 * i], motion[2 * i + 1], GIVEN, elastic_force, dt, NOW)
        elastic_force = step[1]


def begin(m: Floats, values: Floats, fresh: Floats) -> None:
    for j in range(GIVEN):  # loops: slices take numba twice as long to compile
        m[j] = values[j]
    for j in range(N_STATES):
        m[NOW + j] = fresh[j]


def elapsed(m: Floats, fresh: Floats, t: Floats, first: Floats, i: int) -> float:
    """Return the time since the last sample [s], 0 at the beginning of an episode, whose pause passes in air.

    After the pause all has recovered but what outlives an episode.
    """
    if first[i] < 0.5:
        return float(t[i] - t[i - 1])
    if i > 0:
        advance(m, 0, NOW, 0.0, 0.0, GIVEN, 0.0, t[i] - t[i - 1], NOW)
    for j in range(N_STATES):
        if fresh[N_STATES + j] < 0.5:
            m[NOW + j] = fresh[j]
    return 0.0


def slip_load(
    out: Floats, i: int, n: int, load: float, a: float, k: float, mu: float, f: float, torque: float
) -> None:
    """Limits of row ``i``, and where the load lies within: ``gauge(k, f / (mu N), m / (mu N a))``."""
    moment = abs(torque)
    out[8 * n + i] = mu * load
    out[9 * n + i] = mu * load * a * torsion_limit(k)
    out[10 * n + i] = out[11 * n + i] = out[12 * n + i] = out[13 * n + i] = math.nan
    if not (load > 0.0 and a > 0.0 and f + moment > 0.0):
        return
    used = gauge(k, f / (mu * load), moment / (mu * load * a))
    out[10 * n + i] = used
    out[11 * n + i] = math.hypot(f, moment / a) / used
    out[12 * n + i] = f / used
    out[13 * n + i] = torque / used


def depth_of(m: Floats, wanted: float, elastic_force: float, dt: float, span: Floats) -> float:
    """Return the indentation [m] at which the model's sensor shows ``wanted`` [N], by the Illinois rule.

    Below the least force that the model can show the surface has lifted off; any indentation in air will do.
    """
    trial = NOW + N_STATES
    low, high, x = float(span[0]), float(span[1]), float(span[0])
    f_low = f_high = 0.0
    side = 0
    for i in range(ROUNDS):
        if i == 1:
            x = high
        elif i > 1:
            x = (f_low * high - f_high * low) / (f_low - f_high)
        f = advance(m, 0, NOW, x, 0.0, GIVEN, elastic_force, dt, trial)[3] - wanted
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
