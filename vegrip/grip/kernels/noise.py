"""Whether the noise that a sensor shows while it lives has vanished: a value that stands still much too long.

A live sensor whose noise is not small against its resolution seldom says the same number twice running. With
the share *p* of such repeats, *n* of them in a row happen by chance once in *p^-n* states, so a handful of
equal values proves that it is stuck. What is seldom is learned from the sensor itself while it is well:

* *p*, the share of states that repeat the one before; twice that and three standard deviations more are
  used, because motion makes repeats rarer than they are at rest;
* *r*, the share of states that turn the direction of the last change: 2/3 for white noise, 0 for a smooth
  signal. Only with *r* > 0.3 are the changes the work of noise (a drift of at most 1.5 of its standard
  deviations a state, which takes *p* to 0.57 of its value at rest). A coarse sensor at rest, one that is
  filtered, and one that is read more often than it measures are not judged.

Tangential forces and the torque are judged while the finger presses: in the air a sensor may say nothing. One
that says exactly 0 may have a dead zone. One that comes in a message of its own, which is late or lost, is
given as it was for a while: it has to repeat itself for ``frozen_after``.
"""

import math

from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.stillness import HELD_FORCE

NOISE_WINDOW = 256  # states over which the shares are averaged
NOISY_TURNS = 0.3
MORE_AT_REST = 2.0
FORGIVEN_RUN = 2.0
NEVER_TOO_MANY = 1e9  # repeats; no run is that long


def noise_vanished(f: Floats, t: Wholes, now: int) -> bool:
    """Take in all forces at ``now`` [ns]; return whether one repeats itself too often to be alive."""
    vanished = repeats_too_often(f, t, 0, now)
    for i in range(1, FORCES):
        too_often = repeats_too_often(f, t, i, now)
        long = too_often and float(elapsed_time(now, t.repeat_since[i])) > f.rule.frozen_after
        vanished = vanished or (long and f.state.normal_force > HELD_FORCE and f.state[i] != 0.0)
    return vanished


def repeats_too_often(f: Floats, t: Wholes, i: int, now: int) -> bool:
    """Take in force ``i``; return whether it repeats itself too often."""
    value = f.state[i]
    if value == f.noise_last[i]:
        if t.repeat_run[i] == 0:
            f.repeat_limit[i] = longest_run(f, t, i)
            t.repeat_since[i] = now
        t.repeat_run[i] += 1
        return float(t.repeat_run[i]) >= f.repeat_limit[i]
    if value == value:  # noqa: PLR0124 (NaN is not itself)
        learn_noise(f, t, i, value)
        f.noise_last[i] = value
    return False


def learn_noise(f: Floats, t: Wholes, i: int, value: float) -> None:
    """Average over the run of repeats that ends, and the change that ends it."""
    if t.repeat_run[i] > 0:
        run = min(float(t.repeat_run[i]), FORGIVEN_RUN * f.repeat_limit[i])
        kept = math.pow(1.0 - noise_gain(t, i), run)
        f.repeats[i] = 1.0 - (1.0 - f.repeats[i]) * kept
        f.turns[i] *= kept
        t.noise_count[i] += t.repeat_run[i]
    change, gain = value - f.noise_last[i], noise_gain(t, i)
    turned = 1.0 if change * f.noise_change[i] < 0.0 else 0.0
    f.repeats[i] -= f.repeats[i] * gain
    f.turns[i] += (turned - f.turns[i]) * gain
    if change == change:  # noqa: PLR0124
        f.noise_change[i] = change
    t.noise_count[i] += 1
    t.repeat_run[i] = 0


def noise_gain(t: Wholes, i: int) -> float:
    """Weight of the newest state."""
    return 1.0 / float(min(t.noise_count[i] + 1, NOISE_WINDOW))


def longest_run(f: Floats, t: Wholes, i: int) -> float:
    """Return how many repeats in a row of force ``i`` chance does not explain."""
    if f.rule.frozen_chance <= 0.0 or t.noise_count[i] < NOISE_WINDOW or f.turns[i] < NOISY_TURNS:
        return math.inf
    p = f.repeats[i]
    bound = MORE_AT_REST * p + 3.0 * math.sqrt(p * (1.0 - p) / 256.0) + 3.0 / 256.0
    if not bound < 1.0:
        return math.inf
    run = math.log(f.rule.frozen_chance) / math.log(bound)
    return float(math.ceil(run)) if run < NEVER_TOO_MANY else math.inf
