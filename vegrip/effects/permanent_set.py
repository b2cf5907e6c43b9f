"""Permanent set: the surface does not come all the way back, ``x = delta - d_p``.

``d_p = alpha max(delta_max - x_y, 0) + d_c``: a part that grows with the deepest indentation beyond a yield
depth x_y, and one that creeps in contact, ``d d_c / dt = r x`` (compression set, [Gent2012]_, chapter 7).
Exact for any sequence of depths, and for a constant one in the creeping part.
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def tip(
    x: float,
    dt: float,
    reference_depth: float,
    alpha_p: float,
    x_y: float,
    r_p: float,
    delta_max: float,
    d_c: float,
) -> tuple[float, float, float]:
    """Return the indentation of the set surface [m], the deepest displacement [m], the crept set [m]."""
    delta_max = max(delta_max, x)
    yielded = alpha_p * max(delta_max - x_y * reference_depth, 0.0)
    depth = x - yielded - d_c
    if depth > 0.0 and r_p > 0.0:
        d_c = d_c - depth * math.expm1(-r_p * dt)
    return x - yielded - d_c, delta_max, d_c


EFFECT = Effect(
    name="permanent_set",
    summary="after a deep or long contact the next one begins later",
    residual="first touch moves later, and stays there",
    cites=("Gent2012",),
    parameters=(
        Parameter("alpha_p", "1", 0.02, 0.02, 0.0, 0.9, "set over depth beyond x_y", null=0.0),
        Parameter("x_y", "1", 0.3, 0.3, 0.0, 10.0, "depth of yield, in x_ref", of="x_ref"),
        Parameter("r_p", "1/s", 1e-3, 3e-3, 0.0, 1.0, "rate at which the set creeps", null=0.0),
    ),
    states=(
        State("delta_max", "m", "deepest displacement so far", low="x", high="x", extreme=True, lasting=True),
        State("d_c", "m", "set that has crept", lasting=True),
    ),
    hooks=(hook(tip),),
    confounded=("mullins_softening", "second_relaxation", "displacement_backlash"),
    experiment="light touch before and after a deep press and a rest of 10 min",
)
