"""Mullins softening: below the deepest indentation so far the material is softer.

``N_e *= 1 - r [(1 - l) tanh((x_max - x) / w) + l (1 - x / x_max)]``: filled rubber breaks bonds up to its
largest strain and follows a softer path below it, [Mullins1969]_. The tanh returns to the virgin curve
within a width w of it (as the erf of [OgdenRoxburgh1999]_ does), the linear share l over the whole way.
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def softened(elastic_force: float, x: float, x_max: float, r: float, width: float, linear: float) -> float:
    """Return the elastic force [N] at ``x`` [m] > 0 below the deepest indentation ``x_max`` [m]."""
    near = math.tanh((x_max - x) / width)
    return elastic_force * (1.0 - r * ((1.0 - linear) * near + linear * (1.0 - x / x_max)))


def elastic(
    elastic_force: float,
    x: float,
    reference_depth: float,
    r_m: float,
    w_m: float,
    l_m: float,
    x_max: float,
) -> tuple[float, float]:
    """Return the elastic force [N] and the deepest indentation [m]."""
    x_max = max(x_max, x)
    if x <= 0.0 or r_m == 0.0:
        return elastic_force, x_max
    return softened(elastic_force, x, x_max, r_m, w_m * reference_depth, l_m), x_max


EFFECT = Effect(
    name="mullins_softening",
    summary="the first loading is stiffer than those after it",
    residual="first loading differs from the next below the old peak; the order of trials matters",
    cites=("Mullins1969", "OgdenRoxburgh1999"),
    parameters=(
        Parameter("r_m", "1", 0.1, 0.1, 0.0, 0.9, "fraction of the force that is lost", null=0.0),
        Parameter(
            "w_m", "1", 0.6, 0.7, 0.01, 100.0, "width of the return, in x_ref", transform="log", of="x_ref"
        ),
        Parameter("l_m", "1", 0.5, 0.3, 0.0, 1.0, "share that is linear in depth"),
    ),
    states=(
        State("x_max", "m", "deepest indentation so far", low="x", high="x", extreme=True, lasting=True),
    ),
    hooks=(hook(elastic),),
    confounded=("healing_softening", "permanent_set", "displacement_backlash"),
    experiment="triangles of growing peak, then back to a small one",
    companions=("healing_softening",),
)
