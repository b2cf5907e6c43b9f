"""Extended Kalman filter of one contact: state (delta, speed, effect states, learned parameters, d0, bF).

::

    delta' = speed,  speed' = white,  effects' = advance(...),  parameters, d0, bF: random walks
    displacement = delta + d0 + noise,   normal_force = sensed_force + bF + noise,   contact_radius = a + noise

The model enters only through ``advance`` and ``readout``, so any list of effects works; derivatives are
finite differences of them, scaled by the standard deviations. Measurements are scalar and come one after the
other, each linearised where the last one has left the state. Written for numba: plain loops over one flat
array ``m`` per finger, whose places are constants of the generated module (:mod:`vegrip.estimator.layout`).
"""

import math

from vegrip.estimator.generated import *  # noqa: F403


def clear(m, start, end):
    """Set a section to zero."""
    for i in range(start, end):
        m[i] = 0.0


def copy_state(m):
    """Copy the state to TRY, the one that is varied."""
    for i in range(N):
        m[TRY0 + i] = m[Y0 + i]


def put_learned(m, y):
    """Write the learned parameters of the state ``y`` into the values the model reads."""
    for j in range(N_LEARNED):
        u = m[y + 2 + NS + j]
        m[VALUES0 + LEARNED[j]] = math.exp(u) if LEARNED_LOG[j] else u


def step_of(m, y, j):
    """Difference step of coordinate ``j``: a thousandth of its standard deviation."""
    sd = math.sqrt(max(m[P0 + j * N + j], 0.0))
    return max(1e-3 * sd, 1e-8 * abs(m[y + j]))


def propagate(m, y, dt, into):
    """Effect states after ``dt``, the indentation running on at constant speed."""
    put_learned(m, y)
    _, before, _, _ = advance(m, VALUES0, y + 2, m[y], m[y + 1], EXOGENOUS0, 0.0, 0.0, into)
    advance(m, VALUES0, into, m[y] + m[y + 1] * dt, m[y + 1], EXOGENOUS0, before, dt, into)


def contact(m, y):
    """``x``, ``elastic_force``, ``force``, ``sensed_force`` of the state ``y``."""
    put_learned(m, y)
    return advance(m, VALUES0, y + 2, m[y], m[y + 1], EXOGENOUS0, 0.0, 0.0, S10)


def predict(m, dt, rho):
    """Move state and covariance by ``dt`` [s]; ``rho`` is what is left of the speed (1 = all)."""
    y, now, later, other = Y0, TRY0, S00, S10
    copy_state(m)
    if NS > 0:
        propagate(m, now, dt, later)
        for j in range(M):
            h = 0.0 if j >= 2 + NS and m[LOAD0 + 1] > 0.5 else step_of(m, y, j)
            if h > 0.0:
                m[now + j] = m[y + j] + h
                propagate(m, now, dt, other)
                m[now + j] = m[y + j]
                for i in range(NS):
                    m[F0 + i * M + j] = (m[other + i] - m[later + i]) / h
            else:
                for i in range(NS):
                    m[F0 + i * M + j] = 0.0
        hold_extremes(m, later)
    R = 2 + NS  # rows that move: B = F P, then P = B F' (parameters, d0 and bF stay)
    for c in range(N):
        m[B0 + c] = m[P0 + c] + dt * m[P0 + N + c]
        m[B0 + N + c] = rho * m[P0 + N + c]
    for i in range(NS):
        for c in range(N):
            s = 0.0
            for j in range(M):
                s += m[F0 + i * M + j] * m[P0 + j * N + c]
            m[B0 + (2 + i) * N + c] = s
    for a in range(R):
        for c in range(R, N):
            m[P0 + a * N + c] = m[B0 + a * N + c]
            m[P0 + c * N + a] = m[B0 + a * N + c]
    for a in range(R):
        row = a * N
        if a < 1:
            m[P0 + 0] = m[B0 + 0] + dt * m[B0 + 1]
        if a < 2:
            m[P0 + row + 1] = rho * m[B0 + row + 1]
            m[P0 + N + a] = m[P0 + row + 1]
        for i in range(NS):
            s = 0.0
            for j in range(M):
                s += m[F0 + i * M + j] * m[B0 + row + j]
            m[P0 + row + 2 + i] = s
            m[P0 + (2 + i) * N + a] = s
    m[y] += m[y + 1] * dt
    m[y + 1] *= rho
    for i in range(NS):
        m[y + 2 + i] = m[later + i]
    q = m[SET_ACCELERATION] * m[MOTION0]
    m[P0 + 0] += q * dt * dt * dt / 3.0
    m[P0 + 1] += q * dt * dt / 2.0
    m[P0 + N] = m[P0 + 1]
    m[P0 + N + 1] += q * dt
    for j in range(2, N):
        m[P0 + j * N + j] += m[DRIFT0 + j] * dt
    leash(m, 0, m[PRIOR0])
    leash(m, 1, m[PRIOR0 + 1])
    for j in range(2 + NS, N):
        leash(m, j, m[PRIOR0 + j] * 1.0000001)


def hold_extremes(m, later):
    """The maximum of noisy values is not the noisy value of the maximum: discount new extremes by the noise.

    The noise is what the indentation does from sample to sample, without its slow zero error d0.
    """
    slow = m[P0 + N - 2] * m[P0 + N - 2] / max(m[P1 - 1 - N - 1], 1e-300)
    quick = math.sqrt(max(min(m[P0] - slow, m[SET_R_DISPLACEMENT]), 0.0))
    for i in range(NS):
        if KEPT[2 + i]:
            old, noise = m[Y0 + 2 + i], 2.5 * abs(m[F0 + i * M]) * quick
            if m[later + i] > old:
                m[later + i] = max(old, m[later + i] - noise)
            else:
                m[later + i] = min(old, m[later + i] + noise)


def leash(m, j, limit):
    """No coordinate gets less certain than at the very beginning: scale its row and column."""
    variance = m[P0 + j * N + j]
    if variance > limit:
        factor = math.sqrt(limit / variance)
        for c in range(N):
            m[P0 + j * N + c] *= factor
            m[P0 + c * N + j] *= factor


def bound(m):
    """Keep the state where the model makes sense."""
    y = Y0
    R = m[SET_TIP_RADIUS]
    m[y] = min(max(m[y], -100.0 * R), R)
    for j in range(2 + NS, M):
        m[y + j] = min(max(m[y + j], m[LOW0 + j]), m[HIGH0 + j])


def scalar_update(m, channel, innovation, R):
    """One measurement with the gradient in section H; returns False when the gate refuses it.

    Above NIS 9 the weight falls as in Huber's estimate (the innovation variance grows with sqrt(NIS / 9)),
    above 100 the measurement is refused.

    A running maximum (KEPT) has no gain: it follows the estimate upwards by itself, and corrected downwards
    with it, it would forget the maximum. The covariance is that of the gain used, so it stays one.
    """
    y = Y0
    S = R
    for i in range(N):
        s = 0.0
        for j in range(N):
            s += m[P0 + i * N + j] * m[H0 + j]
        m[G0 + i] = s
    for i in range(N):
        S += m[H0 + i] * m[G0 + i]
    at = CHANNEL0 + 4 * channel
    nis = innovation * innovation / S
    note(m, channel, innovation / math.sqrt(S), nis)
    if not nis <= 100.0:
        m[at + CH_STREAK] += 1.0
        m[at + CH_REJECTED] += 1.0
        return False
    if channel == 0:
        restless(m, nis)
    m[at + CH_STREAK] = 0.0
    m[at + CH_AGE] = 0.0
    m[at + CH_USED] = 1.0
    if nis > 9.0:
        S *= math.sqrt(nis / 9.0)
    # in contact and without a displacement nothing tells the bias of the force from the force
    bias_kept = m[LOAD0 + 1] > 0.5 and channel == 1 and m[H0] > 0.0
    for i in range(N):
        m[K0 + i] = 0.0 if KEPT[i] or (i == N - 1 and bias_kept) else m[G0 + i] / S
        m[y + i] += m[K0 + i] * innovation
    for i in range(N):
        for j in range(i, N):
            a, b = m[K0 + i], m[K0 + j]
            m[P0 + i * N + j] -= a * m[G0 + j] + (m[G0 + i] - a * S) * b
            m[P0 + j * N + i] = m[P0 + i * N + j]
        floor = 1e-12 * m[G0 + i] * m[G0 + i] / S  # what rounding may have left of a variance
        m[P0 + i * N + i] = max(m[P0 + i * N + i], floor)
    bound(m)
    return True


def restless(m, nis):
    """Adapt how restless the motion is taken to be, a factor on the density of the acceleration.

    In a hold a filter that expects motion takes the noise of the displacement for motion, and the missing
    answer of the force for a soft contact: stiffness and relaxation came out low by two standard deviations.
    """
    calm = m[MOTION0] * (1.0 + 0.03 * (min(nis, 25.0) - 1.0))
    if nis > 9.0:
        calm = max(calm, 1.0)
    m[MOTION0] = min(max(calm, 1e-4), 100.0)


def note(m, channel, normalised, nis):
    """Remember the innovation for the consistency check, by channel and regime."""
    at = HEALTH0 + 3 * (4 * channel + int(m[LOAD0 + 3]))
    keep = m[LOAD0 + 2]  # exp(-dt / memory), set by update
    m[at] = keep * m[at] + 1.0
    gain = 1.0 / m[at]
    m[at + 1] += gain * (min(max(normalised, -10.0), 10.0) - m[at + 1])
    m[at + 2] += gain * (min(nis, 100.0) - m[at + 2])


def regime_of(m):
    """0 air, 1 loading, 2 hold, 3 unloading."""
    if m[REP_CONTACT] < 0.5:
        return 0.0
    slow = 2.0 * math.sqrt(max(m[P0 + N + 1], 0.0))
    if abs(m[Y0 + 1]) <= slow:
        return 2.0
    return 1.0 if m[Y0 + 1] > 0.0 else 3.0


def measure_displacement(m, value):
    """``displacement = delta + d0``."""
    clear(m, H0, H1)
    m[H0 + 0] = 1.0
    m[H0 + N - 2] = 1.0
    return scalar_update(m, 0, value - m[Y0] - m[Y0 + N - 2], m[SET_R_DISPLACEMENT])


def force_gradient(m, y):
    """Fill H with the derivative of the sensed force at ``y``; return that force."""
    clear(m, H0, H1)
    base = contact(m, y)[3]
    for j in range(2 + NS if m[LOAD0 + 1] > 0.5 else M):
        h = step_of(m, y, j)
        if h > 0.0:
            keep = m[y + j]
            m[y + j] = keep + h
            m[H0 + j] = (contact(m, y)[3] - base) / h
            m[y + j] = keep
    m[H0 + N - 1] = 1.0
    return base


def measure_force(m, value, alone):
    """``normal_force = sensed_force + bF``; ``alone``: the displacement is not known, force tells it."""
    y = TRY0
    copy_state(m)
    R = m[SET_R_FORCE]
    bias = m[y + N - 1]
    if alone:
        meet(m, y, value - bias, 3.0 * math.sqrt(R + m[P1 - 1]))
    base = force_gradient(m, y)
    innovation = value - base - bias
    spread = 0.0
    for i in range(M):
        for j in range(M):
            spread += m[H0 + i] * m[P0 + i * N + j] * m[H0 + j]
    if value > 20.0 * math.sqrt(R) and base > 0.0 and base + bias > 0.0 and spread > 0.04 * base * base:
        # stiffness hardly known: the logarithm of the force is linear in the logarithm of the stiffness
        predicted = base + bias
        innovation = math.log(value / predicted)
        for j in range(N):
            m[H0 + j] /= predicted
        R /= value * value
    for j in range(M):
        innovation -= m[H0 + j] * (m[Y0 + j] - m[y + j])
    return scalar_update(m, 1, innovation, R)


def meet(m, y, force, threshold):
    """Move the point of linearisation to the indentation at which the model gives the force.

    At first touch the model's slope is zero and a linearisation there would never leave the air.
    """
    if force < threshold:
        return
    found = contact(m, y)[3]
    if abs(found - force) < threshold:
        return
    low, high = min(m[y], 0.0), m[SET_TIP_RADIUS]
    for _ in range(40):
        m[y] = 0.5 * (low + high)
        if contact(m, y)[3] < force:
            low = m[y]
        else:
            high = m[y]


def lose_sight(m):
    """No displacement any more: from here on the indentation is the one the present parameters give.

    Force alone cannot tell stiffness from indentation, and a filter linearised anew at every force believes
    that it can. So the parameters are taken as known in the filter, uncorrelated with the rest, and their
    spread enters where something is published, at constant force (``sight_slope``).
    """
    for i in range(2 + NS, M):
        for j in range(N):
            if not 2 + NS <= j < M:
                m[P0 + i * N + j] = 0.0
                m[P0 + j * N + i] = 0.0


def sight_slope(m, y, j):
    """Change of the indentation with learned parameter ``j`` at constant force, ``- N_theta / N_delta``."""
    base = contact(m, y)[2]
    keep, h = m[y], step_of(m, y, 0)
    m[y] = keep + h
    by_depth = (contact(m, y)[2] - base) / h if h > 0.0 else 0.0
    m[y] = keep
    keep, h = m[y + j], step_of(m, y, j)
    m[y + j] = keep + h
    by_parameter = (contact(m, y)[2] - base) / h if h > 0.0 else 0.0
    m[y + j] = keep
    return -by_parameter / by_depth if by_depth > 0.0 else 0.0


def regain_sight(m):
    """A displacement again: the indentation carries the spread of the parameters it was told by."""
    copy_state(m)
    for j in range(2 + NS, M):
        slope = sight_slope(m, TRY0, j)
        for c in range(N):
            m[P0 + c] += slope * m[P0 + j * N + c]
        for c in range(N):
            m[P0 + c * N] += slope * m[P0 + c * N + j]


def measure_radius(m, value):
    """``contact_radius = a``."""
    y = TRY0
    copy_state(m)
    clear(m, H0, H1)
    base = radius_of(m, y)
    if base <= 0.0:
        return False
    for j in range(M):
        h = step_of(m, y, j)
        if h > 0.0:
            keep = m[y + j]
            m[y + j] = keep + h
            m[H0 + j] = (radius_of(m, y) - base) / h
            m[y + j] = keep
    return scalar_update(m, 2, value - base, m[SET_R_RADIUS])


def radius_of(m, y):
    """Contact radius of the state ``y``."""
    x, elastic_force, force, _ = contact(m, y)
    return readout(m, VALUES0, S10, m[y], m[y + 1], EXOGENOUS0, x, elastic_force, force)[0]


def widen(m, from_displacement, displacement):
    """After many refusals in a row: the motion and the memory are unknown again, what is learned wide."""
    y = Y0
    if from_displacement:
        m[y] = displacement - m[y + N - 2]
        m[y + 1] = 0.0
    for j in range(N):
        m[P0 + j * N + j] += m[PRIOR0 + j]
    for j in range(NS):
        variance = settled_spread(m, j)
        m[P0 + (2 + j) * N + 2 + j] += variance


def settled_spread(m, j):
    """Variance of an effect state about which nothing is known in this contact."""
    x, elastic_force, force, _ = contact(m, Y0)
    low, high = named(STATE_LOW[j], x, elastic_force, force), named(STATE_HIGH[j], x, elastic_force, force)
    return (high - low) * (high - low) / 12.0


def named(code, x, elastic_force, force):
    """The quantity a state's bound is named after."""
    if code == 1:
        return elastic_force
    if code == 2:
        return force
    if code == 3:
        return x
    return 0.0


def settle(m, y):
    """Put every effect state into the middle of what it can be at this indentation; unknown history."""
    for _ in range(2):  # a bound may rest on another state
        x, elastic_force, force, _ = contact(m, y)
        for j in range(NS):
            if STATE_HIGH[j] != 0:
                low = named(STATE_LOW[j], x, elastic_force, force)
                m[y + 2 + j] = 0.5 * (low + named(STATE_HIGH[j], x, elastic_force, force))


def begin(m, force, displacement):
    """First sample: the state of nothing known, in the air or in the middle of a contact."""
    y, trial = Y0, TRY0
    clear(m, P0, P1)
    m[y] = displacement if math.isfinite(displacement) else 0.0
    m[y + 1] = 0.0
    for j in range(N):
        m[P0 + j * N + j] = m[PRIOR0 + j]
    touching = m[y] > 4.0 * math.sqrt(m[SET_R_DISPLACEMENT] + m[PRIOR0 + N - 2])
    if math.isfinite(force):
        touching = force > 4.0 * math.sqrt(m[SET_R_FORCE] + m[PRIOR0 + N - 1])
    if not touching:
        return
    copy_state(m)
    if not math.isfinite(displacement):
        meet(m, trial, force, 0.0)
        m[y] = m[trial]
    m[y] = max(m[y], 0.01 * m[SET_DEPTH])
    settle(m, y)
    copy_state(m)
    for j in range(M):  # states move with indentation and stiffness, within their own spread
        h = step_of(m, y, j)
        if (j < 2 or j >= 2 + NS) and h > 0.0:
            h = min(h, 0.01 * max(abs(m[y + j]), 1e-3)) if j >= 2 else min(h, 1e-3 * m[y] + 1e-30)
            m[trial + j] = m[y + j] + h
            settle(m, trial)
            for i in range(NS):
                m[F0 + i * M + j] = (m[trial + 2 + i] - m[y + 2 + i]) / h
            m[trial + j] = m[y + j]
    for i in range(NS):
        for j in range(M):
            if j < 2 or j >= 2 + NS:
                m[P0 + (2 + i) * N + j] = m[F0 + i * M + j] * m[P0 + j * N + j]
                m[P0 + j * N + 2 + i] = m[P0 + (2 + i) * N + j]
    for i in range(NS):
        for k in range(NS):
            s = settled_spread(m, i) if i == k else 0.0
            for j in range(M):
                if j < 2 or j >= 2 + NS:
                    s += m[F0 + i * M + j] * m[P0 + j * N + j] * m[F0 + k * M + j]
            m[P0 + (2 + i) * N + 2 + k] = s
