"""What can be wrong with a slip channel: pure functions from what is true to what is said."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Said = tuple[float, float]
"""Slip flag, slip speed [m/s]."""


@dataclass(slots=True)
class Sound:
    """What the sound channel of a finger says now, and what is known beside it."""

    flag: float
    speed: float
    time: float  # [s] since the fault began
    past: Callable[[float], Said]  # what a sound channel said so many seconds ago
    other: Said  # the next finger's
    true_speed: float  # [m/s] as it was said, without noise
    held: Said  # said when the fault began
    rng: np.random.Generator


Fault = Callable[[Sound], Said]
FLICKER_S = 0.05
"""For so long a channel appears that vanishes again."""


def _constant(flag: float, speed: float) -> Fault:
    return lambda _: (flag, speed)


def _late(seconds: float) -> Fault:
    return lambda now: now.past(seconds)


def _deaf(below: float) -> Fault:
    return lambda now: (now.flag, now.speed) if now.true_speed >= below else (0.0, 0.0)


def _random(now: Sound) -> Said:
    return (1.0 - now.flag if now.rng.random() < 0.02 else now.flag), now.speed


def _random_speed(now: Sound) -> Said:
    """Lone samples of flag and speed that agree."""
    return (1.0, 5e-3) if now.rng.random() < 0.02 else (now.flag, now.speed)


def _noisy(now: Sound) -> Said:
    return now.flag, now.speed + 2e-3 * now.rng.standard_normal()


def _noisy_both(now: Sound) -> Said:
    speed = abs(now.speed + 2e-3 * now.rng.standard_normal())
    return float(speed >= 1e-4), speed


def _scaled(factor: float) -> Fault:
    return lambda now: (now.flag, factor * now.speed)


def _drifting(factor: float) -> Fault:
    return lambda now: (now.flag, factor ** min(now.time / 50.0, 1.0) * now.speed)


def _scaled_both(factor: float) -> Fault:
    return lambda now: (float(factor * now.true_speed >= 1e-4), factor * now.speed)


def _ever_later(now: Sound) -> Said:
    return now.past(0.5 * min(now.time / 50.0, 1.0))


def _loose(now: Sound) -> Said:
    """A loose contact: one second in five it is sound."""
    return (now.flag, now.speed) if now.time % 5.0 < 1.0 else (0.0, 0.0)


def _flicker(now: Sound) -> Said:
    return (1.0, 5e-3) if now.time < FLICKER_S else (math.nan, math.nan)


FAULTS: dict[str, Fault] = {
    "dead": _constant(0.0, 0.0),
    "dead-flag-only": _constant(0.0, math.nan),
    "dead-flag": lambda now: (0.0, now.speed),
    "dead-speed": lambda now: (now.flag, 0.0),
    "dead-noisy": lambda now: (0.0, 5e-5 * now.rng.standard_normal()),
    "absent": _constant(math.nan, math.nan),
    "absent-flag": lambda now: (math.nan, now.speed),
    "frozen": lambda now: now.held,
    "stuck": _constant(1.0, 1e-3),
    "stuck-fast": _constant(1.0, 0.05),
    "stuck-flag": lambda now: (1.0, now.speed),
    "stuck-flag-only": _constant(1.0, math.nan),
    "stuck-speed": lambda now: (now.flag, 5e-3),
    "stuck-half": lambda now: (0.5, now.speed),
    "inverted": lambda now: (1.0 - now.flag, now.speed),
    "late-100": _late(0.1),
    "late-500": _late(0.5),
    "deaf-0.5": _deaf(5e-4),
    "deaf-2": _deaf(2e-3),
    "deaf-10": _deaf(1e-2),
    "random": _random,
    "random-both": _random_speed,
    "noisy": _noisy,
    "noisy-both": _noisy_both,
    "biased": lambda now: (now.flag, now.speed + 5e-3),
    "scaled-0.4": _scaled(0.4),
    "scaled-2.5": _scaled(2.5),
    "drifts-0.4": _drifting(0.4),
    "drifts-2.5": _drifting(2.5),
    "scaled-both-0.4": _scaled_both(0.4),
    "ever-later": _ever_later,
    "loose": _loose,
    "backwards": lambda now: (now.flag, -now.speed),
    "swapped": lambda now: now.other,
    "flicker": _flicker,
    "none": lambda now: (now.flag, now.speed),
}
"""By name; of "none" and "absent" the first is a sound channel, and the second is no channel at all."""
