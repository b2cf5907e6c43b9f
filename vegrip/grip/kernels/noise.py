"""Whether the noise of a living sensor has vanished (:mod:`vegrip.grip.safety.stuck_noise`)."""

import math

from vegrip.grip.kernels.generated import (
    INPUT_COUNT,
    INPUT_RUN,
    RULE_FROZEN_CHANCE,
    STATE_NORMAL_FORCE,
    WATCH_CHANGE,
    WATCH_NOISE_LAST,
    WATCH_REPEAT_LIMIT,
    WATCH_REPEATS,
    WATCH_TURNS,
    Floats,
    Wholes,
)

NOISE_WINDOW = 256  # states over which the shares are averaged
NOISY_TURNS = 0.3
MORE_AT_REST = 2.0
FORGIVEN_RUN = 2.0
NEVER_TOO_MANY = 1e9  # repeats; no run is that long


def noise_vanished(f: Floats, t: Wholes) -> bool:
    """Take in the normal force; return whether it repeats itself too often to be alive."""
    value = f[STATE_NORMAL_FORCE]
    if value == f[WATCH_NOISE_LAST]:
        if t[INPUT_RUN] == 0:
            f[WATCH_REPEAT_LIMIT] = longest_run(f, t)
        t[INPUT_RUN] += 1
        return float(t[INPUT_RUN]) >= f[WATCH_REPEAT_LIMIT]
    if value == value:  # noqa: PLR0124 (NaN is not itself)
        learn_noise(f, t, value)
        f[WATCH_NOISE_LAST] = value
    return False


def learn_noise(f: Floats, t: Wholes, value: float) -> None:
    """Average over the run of repeats that ends, and the change that ends it."""
    if t[INPUT_RUN] > 0:
        run = min(float(t[INPUT_RUN]), FORGIVEN_RUN * f[WATCH_REPEAT_LIMIT])
        kept = math.pow(1.0 - noise_gain(t), run)
        f[WATCH_REPEATS] = 1.0 - (1.0 - f[WATCH_REPEATS]) * kept
        f[WATCH_TURNS] *= kept
        t[INPUT_COUNT] += t[INPUT_RUN]
    change, gain = value - f[WATCH_NOISE_LAST], noise_gain(t)
    turned = 1.0 if change * f[WATCH_CHANGE] < 0.0 else 0.0
    f[WATCH_REPEATS] -= f[WATCH_REPEATS] * gain
    f[WATCH_TURNS] += (turned - f[WATCH_TURNS]) * gain
    if change == change:  # noqa: PLR0124
        f[WATCH_CHANGE] = change
    t[INPUT_COUNT] += 1
    t[INPUT_RUN] = 0


def noise_gain(t: Wholes) -> float:
    """Weight of the newest state."""
    return 1.0 / float(min(t[INPUT_COUNT] + 1, NOISE_WINDOW))


def longest_run(f: Floats, t: Wholes) -> float:
    """Return how many repeats in a row chance does not explain."""
    if f[RULE_FROZEN_CHANCE] <= 0.0 or t[INPUT_COUNT] < NOISE_WINDOW or f[WATCH_TURNS] < NOISY_TURNS:
        return math.inf
    p = f[WATCH_REPEATS]
    bound = MORE_AT_REST * p + 3.0 * math.sqrt(p * (1.0 - p) / 256.0) + 3.0 / 256.0
    if not bound < 1.0:
        return math.inf
    run = math.log(f[RULE_FROZEN_CHANCE]) / math.log(bound)
    return float(math.ceil(run)) if run < NEVER_TOO_MANY else math.inf
