"""An effect whose hook uses what C99 has not."""

import math

from vegrip.effects import Effect, hook


def sense(sensed_force: float) -> float:
    """Return the next number [N]."""
    shifted = sensed_force + 1.0
    return math.nextafter(shifted, 0.0)


EFFECT = Effect("bad_effect", "to be refused", (), (hook(sense),))
