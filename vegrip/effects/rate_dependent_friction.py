"""Friction that depends on the slip speed (Stribeck and logarithmic creep).

``mu_eff = mu [r + (1 - r) exp(-(v / v_s)^2) + beta ln(1 + v / v_0)]``

mu is the static coefficient and r the ratio of kinetic to static; the speeds are in x_ref per second. The
Stribeck part is that of [ArmstrongDupontCanudas1994]_, the logarithm that of thermally activated sliding,
[Ruina1983]_. While the contact sticks v is 0 and the limit is the static one.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def friction(
    friction: float,
    slip_speed: float,
    reference_depth: float,
    r_mu: float,
    v_s: float,
    beta_v: float,
    v_0: float,
) -> float:
    """Return the friction coefficient."""
    v = abs(slip_speed) / reference_depth
    stuck = math.exp(-((v / v_s) ** 2))
    factor = stuck + r_mu * (1.0 - stuck) + beta_v * math.log1p(v / v_0)
    return friction * max(factor, 0.01)


EFFECT = Effect(
    name="rate_dependent_friction",
    summary="the friction coefficient depends on the slip speed",
    residual="force while sliding depends on the speed",
    cites=("ArmstrongDupontCanudas1994", "Ruina1983"),
    parameters=(
        Parameter("r_mu", "1", 0.85, 0.15, 0.1, 1.0, "ratio of kinetic to static", transform="log", null=1.0),
        Parameter(
            "v_s", "1/s", 1.0, 1.5, 1e-5, 1e5, "Stribeck speed, x_ref/s", transform="log", of="x_ref/s"
        ),
        Parameter("beta_v", "1", 0.03, 0.03, -0.3, 0.5, "growth per e-fold of speed", null=0.0),
        Parameter(
            "v_0", "1/s", 0.1, 1.5, 1e-7, 1e4, "speed of onset, x_ref/s", transform="log", of="x_ref/s"
        ),
    ),
    hooks=(hook(friction),),
    channels=("tangential_force", "torque_z"),
    confounded=("friction_ageing", "presliding"),
    experiment="slides at four speeds over three decades",
)
