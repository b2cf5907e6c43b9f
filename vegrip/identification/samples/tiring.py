"""A pad that tires: ``N *= 1 - r_w (1 - exp(-w / w_0))``, ``w`` the way rubbed in and out in units of x_ref.

No effect of the catalogue does this: a law to hide in a simulation, and to find again with `vegrip draft`.
"""

import math

from vegrip.effects import Effect, State, hook
from vegrip.parameters import Parameter


def force(
    force: float, x: float, speed: float, reference_depth: float, dt: float, r_w: float, w_0: float, w: float
) -> tuple[float, float]:
    """Return the force [N] and the way so far [x_ref]."""
    if x > 0.0:
        w = w + abs(speed) / reference_depth * dt
    return force * (1.0 - r_w * (1.0 - math.exp(-w / w_0))), w


EFFECT = Effect(
    name="tiring",
    summary="the pad gets softer the longer it is rubbed in and out",
    cites=("own",),
    parameters=(
        Parameter("r_w", "1", 0.25, 0.2, 0.0, 0.9, "fraction of the force that is lost in the end", null=0.0),
        Parameter("w_0", "1", 12.0, 0.7, 0.1, 1e4, "way after which most of it is lost", transform="log"),
    ),
    states=(State("w", "1", "way rubbed in and out so far", lasting=True),),
    hooks=(hook(force),),
    experiment="a hundred small presses, then a large one",
)
