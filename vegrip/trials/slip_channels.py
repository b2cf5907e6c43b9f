"""Slip channels of a hand that are wrong at every finger from the start, without telling the controller."""

from collections.abc import Callable

import numpy as np

from vegrip.types import Floats

SLIP_CHANNELS = ("absent", "sound", "dead", "stuck", "noisy")
"""dead: flag and speed are 0, whatever slides; stuck: they say slip, whatever holds; noisy: some of the flags
are wrong, and the speed has the noise below besides; absent: not measured."""

WRONG_FLAGS, SPEED_NOISE_M_S = 0.02, 2e-3  # of a noisy slip channel
STUCK_SPEED_M_S = 1e-3  # that a stuck channel says
FLAG, SPEED = 6, 7  # columns of the sensed values (:class:`vegrip.hand_sample.HandSample`)


def wrong_slip(channel: str, seed: int) -> Callable[[Floats], None] | None:
    """Return what a slip channel does to the values of a sample, in place; None: nothing is wrong."""
    if channel == "noisy":
        rng = np.random.default_rng([seed, 4])

        def spoil(values: Floats) -> None:
            noise, wrong = rng.standard_normal(len(values)), rng.random(len(values)) < WRONG_FLAGS
            values[wrong, FLAG] = 1.0 - values[wrong, FLAG]
            values[:, SPEED] = np.maximum(values[:, SPEED] + SPEED_NOISE_M_S * noise, 0.0)

        return spoil
    said = {"dead": (0.0, 0.0), "stuck": (1.0, STUCK_SPEED_M_S)}.get(channel)
    if said is None:
        return None

    def say(values: Floats) -> None:
        values[:, [FLAG, SPEED]] = said

    return say
