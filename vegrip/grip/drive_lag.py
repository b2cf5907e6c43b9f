"""The lag of each drive, identified while it works: the command is known, the force is measured.

A drive of first order with the lag L follows the command c with the force F = c - L F'. Its model x is moved
by the same commands, so its rate has none of the noise of F, and the gap between command and force is::

    c - F = L x' + s w + b,        x' = (c - x) / L

where s is the stiction of the drive, w (from -1 to 1) tells which way the command has come, and b is what the
force sensor is off. A Kalman filter follows (L, s, b). It takes a sample

* only where the command moves, slowly enough for any rate limit of the drive, and has done so for a while;
* only of a finger that touches, whose state is believed and whose command is no fail-safe;
* with an innovation of at most ``DRIVE_BOUND`` standard deviations, so that one sample moves it by little.

A force that is commanded with one sample is on its way until the next, so the lag behind a need is longer
than L by half of a period. It is known once its standard deviation is below ``DRIVE_SURE`` of it, the model
has moved by ``DRIVE_PATH``, and what it leaves over is noise.

Plain scalar code over the flat sequence of :mod:`~vegrip.grip.friction_probe`, behind its sections and those
of :mod:`~vegrip.grip.friction_onset`; the same text is compiled.
"""

import math

from vegrip.grip.friction_onset import *
from vegrip.types import Numbers

DRIVE_TOLD = ONSET_SIZE  # [s] lag of all drives as it is told; 0 = it is not
DRIVE_IS_MEASURED = ONSET_SIZE + 1  # 1 = the measured lag counts instead, once it is known
DRIVE_BURST = ONSET_SIZE + 2  # [1/s] relative growth of a load that comes in a burst
DRIVE_NOISE = ONSET_SIZE + 3  # [N] std of a normal force
DRIVE_LAG = ONSET_SIZE + 4  # [s] measured behind a need, of finger i from here on
DRIVE_KNOWN = DRIVE_LAG + BELIEF_MOST  # 1 = it is known
DRIVE_BEGUN = DRIVE_KNOWN + BELIEF_MOST
DRIVE_COMMAND = DRIVE_BEGUN + BELIEF_MOST  # [N] the last one
DRIVE_MODEL = DRIVE_COMMAND + BELIEF_MOST  # [N] x
DRIVE_PLAY = DRIVE_MODEL + BELIEF_MOST  # [N] the command behind a play, which tells w
DRIVE_WAIT = DRIVE_PLAY + BELIEF_MOST  # [s] until samples count again
DRIVE_MOVED = DRIVE_WAIT + BELIEF_MOST  # [N] by which the command has moved where samples counted
DRIVE_MISFIT = DRIVE_MOVED + BELIEF_MOST  # [N] mean innovation of late, without its sign
DRIVE_FORCE = DRIVE_MISFIT + BELIEF_MOST  # [N] the last one
DRIVE_SLOPE = DRIVE_FORCE + BELIEF_MOST  # [N/s] smoothed rate of the force
DRIVE_SEEN = DRIVE_SLOPE + BELIEF_MOST  # [N/s] fastest rate with which the drive was seen to follow
DRIVE_STATE = DRIVE_SEEN + BELIEF_MOST  # L [s], s [N], b [N] from 3 i on
DRIVE_P = DRIVE_STATE + 3 * BELIEF_MOST  # their covariance, from 9 i on
DRIVE_SIZE = DRIVE_P + 9 * BELIEF_MOST

DRIVE_USUAL = 0.015  # [s] lag that is expected of a drive
DRIVE_LEAST, DRIVE_MOST = 5e-4, 0.2  # [s] of L
DRIVE_SPREAD = 0.015  # [s] std of L at the beginning
DRIVE_STICTION, DRIVE_OFFSET = 0.02, 0.05  # [N] the same of s and b
DRIVE_WALK = 3e-4  # [s/sqrt(s)] random walk of L while the command moves
DRIVE_OFFSET_WALK = 0.01  # [N/sqrt(s)] the same of b
DRIVE_DOUBT = 3.0  # times the noise of the force, because what the model leaves out lasts for many samples
DRIVE_BOUND = 3.0  # standard deviations of an innovation
DRIVE_REST = 0.01  # [s] without a fast motion before samples count
DRIVE_FASTEST = 12.0  # [N/s] of a command, beyond which a drive may be at its rate limit
DRIVE_FOLLOWED = 0.7  # of the fastest rate that was seen, up to which it is not
DRIVE_SMOOTH = 0.005  # [s] of that rate
DRIVE_SEEN_TIME = 60.0  # [s] in which it is forgotten
DRIVE_SLOWEST = 0.5  # [N/s] below which the motion tells nothing
DRIVE_FAR = 0.5  # [N] between command and force, where the drive is at its limit or does not listen
DRIVE_WIDTH = 0.02  # [N] of the play that tells which way the command has come
DRIVE_GAP = 0.05  # [s] between two samples, after which the drive is followed anew
DRIVE_SURE, DRIVE_VAGUE = 0.1, 0.2  # relative std of the lag at which it becomes known, and unknown again
DRIVE_FINE = 8e-3  # [s] up to which the std is held against a lag of this
DRIVE_PATH = 4.0  # [N]
DRIVE_EXPLAINED = 2.0  # times the noise of the force: a mean innovation beyond which the model fails
DRIVE_MEMORY = 0.3  # [s] of that mean


def tell_drives(q: Numbers, told: float, measured: bool, burst: float) -> None:
    """Set what is told of the drives; what was measured stays.

    Args:
        q: the state.
        told: their lag [s]; 0 where it is not told.
        measured: whether the measured lag counts once it is known.
        burst: relative growth of a load that comes in a burst [1/s].

    """
    q[DRIVE_TOLD], q[DRIVE_IS_MEASURED], q[DRIVE_BURST] = told, 1.0 if measured else 0.0, burst


def begin_drives(q: Numbers, noise: float) -> None:
    """Begin with drives of which nothing was seen yet; ``noise`` is the std of a normal force [N]."""
    q[DRIVE_NOISE] = noise
    for i in range(BELIEF_MOST):
        q[DRIVE_LAG + i] = q[DRIVE_KNOWN + i] = q[DRIVE_BEGUN + i] = q[DRIVE_MOVED + i] = 0.0
        q[DRIVE_MISFIT + i] = q[DRIVE_SEEN + i] = 0.0
        q[DRIVE_STATE + 3 * i] = DRIVE_USUAL
        q[DRIVE_STATE + 3 * i + 1] = q[DRIVE_STATE + 3 * i + 2] = 0.0
        for j in range(9):
            q[DRIVE_P + 9 * i + j] = 0.0
        q[DRIVE_P + 9 * i] = DRIVE_SPREAD * DRIVE_SPREAD
        q[DRIVE_P + 9 * i + 4] = DRIVE_STICTION * DRIVE_STICTION
        q[DRIVE_P + 9 * i + 8] = DRIVE_OFFSET * DRIVE_OFFSET


def follow_drive(q: Numbers, i: int, dt: float, command: float, force: float) -> None:
    """Take in the normal ``force`` [N] of finger ``i`` under the ``command`` [N] of the last ``dt`` [s].

    One of them that is not a number tells that this sample does not count, and the drive is followed anew.
    """
    if not (abs(command) + abs(force) < math.inf and 0.0 < dt <= DRIVE_GAP):
        q[DRIVE_BEGUN + i] = 0.0
        return
    if q[DRIVE_BEGUN + i] == 0.0:
        q[DRIVE_BEGUN + i] = 1.0
        q[DRIVE_COMMAND + i] = q[DRIVE_PLAY + i] = command
        q[DRIVE_MODEL + i] = force
        q[DRIVE_FORCE + i], q[DRIVE_SLOPE + i] = force, 0.0
        q[DRIVE_WAIT + i] = DRIVE_REST
        return
    watch_rate(q, i, dt, command, force)
    change = abs(command - q[DRIVE_COMMAND + i])
    q[DRIVE_COMMAND + i] = command
    lag = q[DRIVE_STATE + 3 * i]
    q[DRIVE_MODEL + i] += (1.0 - math.exp(-dt / lag)) * (command - q[DRIVE_MODEL + i])
    q[DRIVE_PLAY + i] = min(max(q[DRIVE_PLAY + i], command - DRIVE_WIDTH), command + DRIVE_WIDTH)
    fastest = max(DRIVE_FASTEST, DRIVE_FOLLOWED * q[DRIVE_SEEN + i])
    if change > fastest * dt or abs(command - force) > DRIVE_FAR:
        if q[DRIVE_WAIT + i] >= DRIVE_REST:  # for the second time: not one bad sample
            q[DRIVE_MODEL + i] = force
        q[DRIVE_WAIT + i] = DRIVE_REST
        return
    q[DRIVE_WAIT + i] = max(q[DRIVE_WAIT + i] - dt, 0.0)
    rate = (command - q[DRIVE_MODEL + i]) / lag
    if q[DRIVE_WAIT + i] > 0.0 or abs(rate) < DRIVE_SLOWEST:
        return
    q[DRIVE_MOVED + i] += abs(rate) * dt
    measure_drive(q, i, dt, rate, (command - q[DRIVE_PLAY + i]) / DRIVE_WIDTH, command - force)
    judge_drive(q, i, dt)


def watch_rate(q: Numbers, i: int, dt: float, command: float, force: float) -> None:
    """Note the fastest rate [N/s] with which the force was seen to follow the command."""
    rate = (force - q[DRIVE_FORCE + i]) / dt
    q[DRIVE_FORCE + i] = force
    q[DRIVE_SLOPE + i] += (1.0 - math.exp(-dt / DRIVE_SMOOTH)) * (rate - q[DRIVE_SLOPE + i])
    follows = (command - force) * q[DRIVE_SLOPE + i] > 0.0
    seen = math.exp(-dt / DRIVE_SEEN_TIME) * q[DRIVE_SEEN + i]
    q[DRIVE_SEEN + i] = max(abs(q[DRIVE_SLOPE + i]), seen) if follows else seen


def measure_drive(q: Numbers, i: int, dt: float, rate: float, way: float, gap: float) -> None:
    """Update lag, stiction and offset by one gap [N] at the ``rate`` [N/s] of the model."""
    x, p = DRIVE_STATE + 3 * i, DRIVE_P + 9 * i
    q[p] = min(q[p] + DRIVE_WALK * DRIVE_WALK * dt, DRIVE_SPREAD * DRIVE_SPREAD)
    q[p + 8] = min(q[p + 8] + DRIVE_OFFSET_WALK * DRIVE_OFFSET_WALK * dt, DRIVE_OFFSET * DRIVE_OFFSET)
    a = q[p] * rate + q[p + 1] * way + q[p + 2]
    b = q[p + 3] * rate + q[p + 4] * way + q[p + 5]
    c = q[p + 6] * rate + q[p + 7] * way + q[p + 8]
    noise = DRIVE_DOUBT * q[DRIVE_NOISE]
    variance = a * rate + b * way + c + noise * noise
    off = gap - (q[x] * rate + q[x + 1] * way + q[x + 2])
    fade = 1.0 - math.exp(-dt / DRIVE_MEMORY)
    q[DRIVE_MISFIT + i] += fade * (min(abs(off), DRIVE_FAR) - q[DRIVE_MISFIT + i])
    if not variance > 0.0:
        return
    most = DRIVE_BOUND * math.sqrt(variance)
    off = min(max(off, -most), most) / variance
    q[x] = min(max(q[x] + a * off, DRIVE_LEAST), DRIVE_MOST)
    q[x + 1] = min(max(q[x + 1] + b * off, 0.0), DRIVE_FAR)
    q[x + 2] += c * off
    for j in range(3):
        along = (a if j == 0 else b if j == 1 else c) / variance
        q[p + 3 * j] -= along * a
        q[p + 3 * j + 1] -= along * b
        q[p + 3 * j + 2] -= along * c


def judge_drive(q: Numbers, i: int, dt: float) -> None:
    """Tell the lag of finger ``i`` behind a need [s], and whether it is known."""
    lag = q[DRIVE_STATE + 3 * i]
    q[DRIVE_LAG + i] = dt / (1.0 - math.exp(-dt / lag))
    most = DRIVE_VAGUE if q[DRIVE_KNOWN + i] > 0.0 else DRIVE_SURE
    sure = math.sqrt(max(q[DRIVE_P + 9 * i], 0.0)) < most * max(q[DRIVE_LAG + i], DRIVE_FINE)
    moved, explained = (
        q[DRIVE_MOVED + i] >= DRIVE_PATH,
        q[DRIVE_MISFIT + i] < DRIVE_EXPLAINED * q[DRIVE_NOISE],
    )
    q[DRIVE_KNOWN + i] = 1.0 if sure and moved and explained else 0.0


def measured_lag(q: Numbers, i: int) -> float:
    """Return the lag of the drive of finger ``i`` behind a need [s]; NaN: not known."""
    return q[DRIVE_LAG + i] if q[DRIVE_KNOWN + i] > 0.0 else math.nan
