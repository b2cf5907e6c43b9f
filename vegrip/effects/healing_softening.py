"""Softening that heals: Mullins softening whose deepest indentation is forgotten in the pauses.

``x_max' = -nu_h x_max`` out of contact (x <= 0), and else as in :mod:`~vegrip.effects.mullins_softening`:
broken bonds of filled rubber form again at rest, within minutes to weeks, [DianiFayolleGilormini2009]_.
Exact for a step that is in the air as a whole. In contact nothing heals.
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.effects.mullins_softening import softened
from vegrip.parameters import Parameter


def elastic(
    elastic_force: float,
    x: float,
    reference_depth: float,
    r_h: float,
    w_h: float,
    l_h: float,
    x_h: float,
) -> tuple[float, float]:
    """Return the elastic force [N] and the deepest indentation that has not healed [m]."""
    x_h = max(x_h, x)
    if x <= 0.0 or r_h == 0.0:
        return elastic_force, x_h
    return softened(elastic_force, x, x_h, r_h, w_h * reference_depth, l_h), x_h


def heal(x: float, dt: float, nu_h: float, x_h: float) -> float:
    """Return the deepest indentation that has not healed [m]."""
    return x_h if x > 0.0 else x_h * math.exp(-nu_h * dt)


EFFECT = Effect(
    name="healing_softening",
    summary="a loading is softer than the one before it, and the less the longer the pause between them",
    residual="first loading after a pause differs, the more the longer the pause",
    cites=("DianiFayolleGilormini2009", "Mullins1969"),
    parameters=(
        Parameter("r_h", "1", 0.1, 0.1, 0.0, 0.9, "fraction of the force that is lost", null=0.0),
        Parameter(
            "w_h", "1", 0.6, 0.7, 0.01, 100.0, "width of the return, in x_ref", transform="log", of="x_ref"
        ),
        Parameter("l_h", "1", 0.5, 0.3, 0.0, 1.0, "share that is linear in depth"),
        Parameter("nu_h", "1/s", 0.01, 2.3, 1e-4, 1.0, "rate of healing out of contact", transform="log"),
    ),
    states=(
        State(
            "x_h", "m", "deepest indentation not yet healed", low="x", high="x", extreme=True, lasting=True
        ),
    ),
    hooks=(hook(elastic), hook(heal, stage="force", gives="")),
    confounded=("mullins_softening", "permanent_set"),
    experiment="presses of one depth after pauses of 1, 10 and 100 s",
    companions=("mullins_softening",),
    trial_shapes=(("w_h", (0.6,)), ("nu_h", (3e-3, 0.03, 0.3))),
    beyond_simpler=(1, (("nu_h", 4e-4),)),
)
