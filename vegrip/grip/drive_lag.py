"""The lag of each drive, identified while it works: the command is known, the force is measured.

A drive of first order with the lag L follows the command c with the force F = c - L F'. Its model x is moved
by the same commands, so its rate has none of the noise of F, and the gap between command and force is::

    c - F = L x' + s w + b,        x' = (c - x) / L

where s is the stiction of the drive, w (from -1 to 1) shows which way the command has come, and b is what the
force sensor is off. A Kalman filter follows (L, s, b). It takes a sample

* only where the command moves, slowly enough for any rate limit of the drive, and has done so for a while;
* only of a finger that touches, whose state is accepted and whose command is no fail-safe;
* with an innovation of at most ``DRIVE_BOUND`` standard deviations, so that one sample moves it by little.

A force that is commanded with one sample is on its way until the next, so the lag behind a need is longer
than L by half of a period. It is known once its standard deviation is below ``DRIVE_SURE`` of it, the model
has moved by ``DRIVE_PATH``, and what it leaves over is noise.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.friction_belief import *
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory

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
DRIVE_SLOWEST = 0.5  # [N/s] below which the motion shows nothing
DRIVE_FAR = 0.5  # [N] between command and force, where the drive is at its limit or does not listen
DRIVE_WIDTH = 0.02  # [N] of the backlash that shows which way the command has come
DRIVE_GAP = 0.05  # [s] between two samples, after which the drive is followed anew
DRIVE_SURE, DRIVE_VAGUE = 0.1, 0.2  # relative std of the lag at which it becomes known, and unknown again
DRIVE_FINE = 8e-3  # [s] up to which the std is held against a lag of this
DRIVE_PATH = 4.0  # [N]
DRIVE_EXPLAINED = 2.0  # times the noise of the force: a mean innovation beyond which the model fails
DRIVE_MEMORY = 0.3  # [s] of that mean


def set_drives(g: GraspMemory, stated: float, burst: float) -> None:
    """Set what is stated of the drives; what was measured stays.

    Args:
        g: what the grasp shares.
        stated: their lag [s] until it is measured.
        burst: relative growth of a load that comes in a burst [1/s].

    """
    g.drive.stated, g.drive.burst = stated, burst


def begin_drives(g: GraspMemory, noise: float) -> None:
    """Begin with drives of which nothing was seen yet; ``noise`` is the std of a normal force [N]."""
    g.drive.noise = noise
    for i in range(BELIEF_MOST):
        g.drive.lag[i] = g.drive.known[i] = g.drive.begun[i] = g.drive.moved[i] = 0.0
        g.drive.misfit[i] = g.drive.seen[i] = 0.0
        g.drive.state[3 * i] = DRIVE_USUAL
        g.drive.state[3 * i + 1] = g.drive.state[3 * i + 2] = 0.0
        for j in range(9):
            g.drive.p[9 * i + j] = 0.0
        g.drive.p[9 * i] = DRIVE_SPREAD * DRIVE_SPREAD
        g.drive.p[9 * i + 4] = DRIVE_STICTION * DRIVE_STICTION
        g.drive.p[9 * i + 8] = DRIVE_OFFSET * DRIVE_OFFSET


def follow_drive(g: GraspMemory, i: int, dt: float, command: float, force: float) -> None:
    """Take in the normal ``force`` [N] of finger ``i`` under the ``command`` [N] of the last ``dt`` [s].

    One of them that is not a number shows that this sample does not count, and the drive is followed anew.
    """
    if not (abs(command) + abs(force) < math.inf and 0.0 < dt <= DRIVE_GAP):
        g.drive.begun[i] = 0.0
        return
    if g.drive.begun[i] == 0.0:
        g.drive.begun[i] = 1.0
        g.drive.command[i] = g.drive.play[i] = command
        g.drive.model[i] = force
        g.drive.force[i], g.drive.slope[i] = force, 0.0
        g.drive.wait[i] = DRIVE_REST
        return
    watch_rate(g, i, dt, command, force)
    change = abs(command - g.drive.command[i])
    g.drive.command[i] = command
    lag = g.drive.state[3 * i]
    g.drive.model[i] += (1.0 - math.exp(-dt / lag)) * (command - g.drive.model[i])
    g.drive.play[i] = min(max(g.drive.play[i], command - DRIVE_WIDTH), command + DRIVE_WIDTH)
    fastest = max(DRIVE_FASTEST, DRIVE_FOLLOWED * g.drive.seen[i])
    if change > fastest * dt or abs(command - force) > DRIVE_FAR:
        if g.drive.wait[i] >= DRIVE_REST:  # for the second time: not one bad sample
            g.drive.model[i] = force
        g.drive.wait[i] = DRIVE_REST
        return
    g.drive.wait[i] = max(g.drive.wait[i] - dt, 0.0)
    rate = (command - g.drive.model[i]) / lag
    if g.drive.wait[i] > 0.0 or abs(rate) < DRIVE_SLOWEST:
        return
    g.drive.moved[i] += abs(rate) * dt
    measure_drive(g, i, dt, rate, (command - g.drive.play[i]) / DRIVE_WIDTH, command - force)
    judge_drive(g, i, dt)


def watch_rate(g: GraspMemory, i: int, dt: float, command: float, force: float) -> None:
    """Note the fastest rate [N/s] with which the force was seen to follow the command."""
    rate = (force - g.drive.force[i]) / dt
    g.drive.force[i] = force
    g.drive.slope[i] += (1.0 - math.exp(-dt / DRIVE_SMOOTH)) * (rate - g.drive.slope[i])
    follows = (command - force) * g.drive.slope[i] > 0.0
    seen = math.exp(-dt / DRIVE_SEEN_TIME) * g.drive.seen[i]
    g.drive.seen[i] = max(abs(g.drive.slope[i]), seen) if follows else seen


def measure_drive(g: GraspMemory, i: int, dt: float, rate: float, way: float, gap: float) -> None:
    """Update lag, stiction and offset by one gap [N] at the ``rate`` [N/s] of the model."""
    x, p = 3 * i, 9 * i
    g.drive.p[p] = min(g.drive.p[p] + DRIVE_WALK * DRIVE_WALK * dt, DRIVE_SPREAD * DRIVE_SPREAD)
    grown = g.drive.p[p + 8] + DRIVE_OFFSET_WALK * DRIVE_OFFSET_WALK * dt
    g.drive.p[p + 8] = min(grown, DRIVE_OFFSET * DRIVE_OFFSET)
    a = g.drive.p[p] * rate + g.drive.p[p + 1] * way + g.drive.p[p + 2]
    b = g.drive.p[p + 3] * rate + g.drive.p[p + 4] * way + g.drive.p[p + 5]
    c = g.drive.p[p + 6] * rate + g.drive.p[p + 7] * way + g.drive.p[p + 8]
    noise = DRIVE_DOUBT * g.drive.noise
    variance = a * rate + b * way + c + noise * noise
    off = gap - (g.drive.state[x] * rate + g.drive.state[x + 1] * way + g.drive.state[x + 2])
    fade = 1.0 - math.exp(-dt / DRIVE_MEMORY)
    g.drive.misfit[i] += fade * (min(abs(off), DRIVE_FAR) - g.drive.misfit[i])
    if not variance > 0.0:
        return
    most = DRIVE_BOUND * math.sqrt(variance)
    off = min(max(off, -most), most) / variance
    g.drive.state[x] = min(max(g.drive.state[x] + a * off, DRIVE_LEAST), DRIVE_MOST)
    g.drive.state[x + 1] = min(max(g.drive.state[x + 1] + b * off, 0.0), DRIVE_FAR)
    g.drive.state[x + 2] += c * off
    for j in range(3):
        along = (a if j == 0 else b if j == 1 else c) / variance
        g.drive.p[p + 3 * j] -= along * a
        g.drive.p[p + 3 * j + 1] -= along * b
        g.drive.p[p + 3 * j + 2] -= along * c


def judge_drive(g: GraspMemory, i: int, dt: float) -> None:
    """Report the lag of finger ``i`` behind a need [s], and whether it is known."""
    lag = g.drive.state[3 * i]
    g.drive.lag[i] = dt / (1.0 - math.exp(-dt / lag))
    most = DRIVE_VAGUE if g.drive.known[i] > 0.0 else DRIVE_SURE
    sure = math.sqrt(max(g.drive.p[9 * i], 0.0)) < most * max(g.drive.lag[i], DRIVE_FINE)
    is_explained = g.drive.misfit[i] < DRIVE_EXPLAINED * g.drive.noise
    g.drive.known[i] = 1.0 if sure and g.drive.moved[i] >= DRIVE_PATH and is_explained else 0.0


def expected_lag(g: GraspMemory, i: int) -> float:
    """Return the lag of the drive of finger ``i`` [s]; until it is known no less than what is stated."""
    lag = g.drive.state[3 * i]
    return lag if g.drive.known[i] > 0.0 else max(lag, g.drive.stated)


def measured_lag(g: GraspMemory, i: int) -> float:
    """Return the lag of the drive of finger ``i`` behind a need [s]; NaN: not known."""
    return g.drive.lag[i] if g.drive.known[i] > 0.0 else math.nan
