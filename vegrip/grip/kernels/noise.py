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
"""

import math

from vegrip.grip.kernels.generated import *

NOISE_WINDOW = 256  # states over which the shares are averaged
NOISY_TURNS = 0.3
MORE_AT_REST = 2.0
FORGIVEN_RUN = 2.0
NEVER_TOO_MANY = 1e9  # repeats; no run is that long


def noise_vanished(f: Floats, t: Wholes) -> bool:
    """Take in the normal force; return whether it repeats itself too often to be alive."""
    value = f.state.normal_force
    if value == f.watch.noise_last:
        if t.input.run == 0:
            f.watch.repeat_limit = longest_run(f, t)
        t.input.run += 1
        return float(t.input.run) >= f.watch.repeat_limit
    if value == value:  # noqa: PLR0124 (NaN is not itself)
        learn_noise(f, t, value)
        f.watch.noise_last = value
    return False


def learn_noise(f: Floats, t: Wholes, value: float) -> None:
    """Average over the run of repeats that ends, and the change that ends it."""
    if t.input.run > 0:
        run = min(float(t.input.run), FORGIVEN_RUN * f.watch.repeat_limit)
        kept = math.pow(1.0 - noise_gain(t), run)
        f.watch.repeats = 1.0 - (1.0 - f.watch.repeats) * kept
        f.watch.turns *= kept
        t.input.count += t.input.run
    change, gain = value - f.watch.noise_last, noise_gain(t)
    turned = 1.0 if change * f.watch.change < 0.0 else 0.0
    f.watch.repeats -= f.watch.repeats * gain
    f.watch.turns += (turned - f.watch.turns) * gain
    if change == change:  # noqa: PLR0124
        f.watch.change = change
    t.input.count += 1
    t.input.run = 0


def noise_gain(t: Wholes) -> float:
    """Weight of the newest state."""
    return 1.0 / float(min(t.input.count + 1, NOISE_WINDOW))


def longest_run(f: Floats, t: Wholes) -> float:
    """Return how many repeats in a row chance does not explain."""
    if f.rule.frozen_chance <= 0.0 or t.input.count < NOISE_WINDOW or f.watch.turns < NOISY_TURNS:
        return math.inf
    p = f.watch.repeats
    bound = MORE_AT_REST * p + 3.0 * math.sqrt(p * (1.0 - p) / 256.0) + 3.0 / 256.0
    if not bound < 1.0:
        return math.inf
    run = math.log(f.rule.frozen_chance) / math.log(bound)
    return float(math.ceil(run)) if run < NEVER_TOO_MANY else math.inf
