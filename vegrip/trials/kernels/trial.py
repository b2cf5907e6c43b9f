"""A whole trial: hand, sensors and fingers, sampled to rows of truth."""

import math

from vegrip.contact.limit_surface.fast import least_normal_force
from vegrip.grip.friction_change import CHANGE_LEVEL, CHANGE_SPREAD, stated_friction
from vegrip.grip.friction_probe import PROBE_UNKNOWN
from vegrip.trials.kernels.control import control_finger
from vegrip.trials.kernels.generated import (
    G_BELIEVED,
    G_BELIEVED_VAR,
    G_COMMAND,
    G_LEARNS,
    H_COMMAND,
    H_DEPTH,
    H_DROPPED,
    H_EVENT_OPEN,
    H_FLAGS,
    H_FORCE,
    H_K,
    H_MICROS,
    H_MU,
    H_RADIUS,
    H_READING,
    H_SAMPLE_TIME,
    H_SLIDING,
    H_SLIP,
    H_SLIP_DELAY,
    H_SLIP_SENSOR,
    H_SLIP_THRESHOLD,
    H_SLIPS,
    H_SPEEDS,
    H_STEPS,
    H_WRENCH,
    HAND_FINGERS,
    HAND_FLAGS,
    ROW,
    ROW_FINGER,
    Floats,
)
from vegrip.trials.kernels.hand import close_event, hand_tick, hand_time, true_margin

HERTZ_POWER = 1.0 / 3.0
SLIP_ABSENT, SLIP_DEAD, SLIP_STUCK = 0.0, 2.0, 3.0  # of H_SLIP_SENSOR, see trial_memory.SLIP_CHANNELS
STUCK_SPEED = 1e-3  # [m/s] that a stuck channel says


def run_whole_trial(
    m0: Floats, m1: Floats, m2: Floats, m3: Floats, m4: Floats, h: Floats, g: Floats, q: Floats,
    b: Floats, z: Floats, out: Floats,
    periods: float, ticks: float, every: float,
) -> float:  # fmt: skip
    """Run ``periods`` of ``ticks`` each, a row of truth ``every`` so many [s]; return the number of rows.

    ``m0`` to ``m4`` are the estimators of the fingers, ``b`` the burdens by tick, ``z`` bias and noise by
    sample, 1 in the last column where the slip flag is wrong.
    """
    rows = 0
    for period in range(int(periods)):
        if h[H_DROPPED] > 0.5:
            break
        for i in range(HAND_FINGERS):
            h[H_COMMAND + i] = h[G_COMMAND + i]
        for _ in range(int(ticks)):
            hand_tick(h, b)
        for i in range(HAND_FINGERS):
            feel_finger(h, z, period, i)
            if i == 0:
                sense_finger(m0, h, g, q, i)
            elif i == 1:
                sense_finger(m1, h, g, q, i)
            elif i == 2:
                sense_finger(m2, h, g, q, i)
            elif i == 3:
                sense_finger(m3, h, g, q, i)
            else:
                sense_finger(m4, h, g, q, i)
        if hand_time(h) >= rows * every:
            write_row(h, q, out, rows * ROW)
            rows += 1
    if h[H_EVENT_OPEN] > 0.5:
        close_event(h)
    return rows * 1.0


def feel_finger(h: Floats, z: Floats, sample: int, i: int) -> None:
    """Put what the sensors of finger ``i`` say into the section of readings."""
    turned = -1.0 if i == 0 else 1.0
    at, noise = H_READING + 8 * i, 8 * (sample * HAND_FINGERS + i)
    h[at] = quantized(h[H_FORCE + i] + z[noise], h[H_STEPS])
    h[at + 1] = quantized(turned * h[H_WRENCH + 3 * i] + z[noise + 1], h[H_STEPS])
    h[at + 2] = quantized(h[H_WRENCH + 3 * i + 1] + z[noise + 2], h[H_STEPS])
    h[at + 3] = quantized(turned * h[H_WRENCH + 3 * i + 2] + z[noise + 3], h[H_STEPS + 1])
    h[at + 4] = quantized(h[H_DEPTH + i] + z[noise + 4], h[H_STEPS + 2])
    speed = h[H_SLIP + 3 * i + 1]
    sliding = h[H_SLIDING + i]
    if speed < h[H_SLIP_THRESHOLD]:
        speed = sliding = 0.0
    speed = felt_late(h, H_SPEEDS + HAND_FLAGS * i, speed)
    h[at + 6] = max(speed + z[noise + 6], 0.0)
    h[at + 7] = felt_late(h, H_FLAGS + HAND_FLAGS * i, sliding)
    if z[noise + 7] > 0.5:
        h[at + 7] = 1.0 - h[at + 7]
    if h[H_SLIP_SENSOR] == SLIP_ABSENT:
        h[at + 6] = h[at + 7] = math.nan
    elif h[H_SLIP_SENSOR] == SLIP_DEAD:
        h[at + 6] = h[at + 7] = 0.0
    elif h[H_SLIP_SENSOR] == SLIP_STUCK:
        h[at + 6], h[at + 7] = STUCK_SPEED, 1.0


def felt_late(h: Floats, first: int, value: float) -> float:
    """Put ``value`` into the ring from ``first`` on; return what was put there by the delay of slip ago."""
    late = int(h[H_SLIP_DELAY])
    for j in range(late):
        h[first + late - j] = h[first + late - j - 1]
    h[first] = value
    return float(h[first + late])


def quantized(value: float, step: float) -> float:
    """Round to a multiple of ``step``; 0 leaves the value as it is."""
    return round(value / step) * step if step > 0.0 else value


def sense_finger(m: Floats, h: Floats, g: Floats, q: Floats, i: int) -> None:
    """Hand the readings of finger ``i`` to its control."""
    at = H_READING + 8 * i
    control_finger(
        m,
        h,
        g,
        q,
        i,
        h[H_SAMPLE_TIME],
        h[at],
        h[at + 4],
        h[at + 1],
        h[at + 2],
        h[at + 3],
        h[at + 7],
        h[at + 6],
    )


def write_row(h: Floats, q: Floats, out: Floats, at: int) -> None:
    """Write the truth as it is now, in the order of ``ROW_HEAD`` and ``ROW_FINGER``."""
    out[at], out[at + 1], out[at + 2] = hand_time(h), h[H_SLIPS], h[H_MICROS]
    for i in range(HAND_FINGERS):
        c = at + 3 + ROW_FINGER * i
        x, y = h[H_WRENCH + 3 * i], h[H_WRENCH + 3 * i + 1]
        out[c], out[c + 1], out[c + 2] = h[H_FORCE + i], h[G_COMMAND + i], true_margin(h, i)
        out[c + 3], out[c + 4], out[c + 5] = h[H_MU + i], h[H_RADIUS + i], h[H_K + i]
        f, torque = math.sqrt(x * x + y * y), abs(h[H_WRENCH + 3 * i + 2])
        out[c + 6], out[c + 7] = f, torque
        out[c + 8] = least_possible(f, torque, h[H_MU + i], h[H_RADIUS + i], h[H_K + i], h[H_FORCE + i])
        out[c + 9], out[c + 10] = told_ln_mu(h, q, i)


def told_ln_mu(h: Floats, q: Floats, i: int) -> tuple[float, float]:
    """Return mean and std of ln mu that are stated of finger ``i``; NaN without a contact."""
    mean, std = h[G_BELIEVED + i], math.sqrt(h[G_BELIEVED_VAR + i])
    if h[G_LEARNS] < 0.5:
        return mean, std
    return stated_friction(mean, std, q[CHANGE_LEVEL + i], q[CHANGE_SPREAD + i], q[PROBE_UNKNOWN])


def least_possible(f: float, torque: float, mu: float, a: float, k: float, force: float) -> float:
    """Return the force [N] at which a load is on the limit surface, the radius going with its cube root.

    ``a`` [m] is the radius at the present ``force`` [N]; without a contact only no load can be carried.
    """
    if not (force > 0.0 and a > 0.0):
        return 0.0 if f + torque == 0.0 else math.inf
    return least_normal_force(f, torque, mu, a, k, force, HERTZ_POWER, 0.0)
