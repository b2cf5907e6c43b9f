"""A soft layer on a hard core: the thin layer stiffens, and far in the core itself is met.

``N_e *= 1 + 1.133 X + 1.283 X^2 + 0.769 X^3 + 0.0975 X^4``, ``X = sqrt(R x) / H``: a sphere on an
incompressible layer of thickness H bonded to a rigid base, [DimitriadisEtAl2002]_, eq. (10); H enters as R
/ H. Then ``N_e += K_c ((x - x_c) / x_ref)^(3/2)`` beyond the depth x_c, a Hertzian contact of the core
itself.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def elastic(
    elastic_force: float,
    x: float,
    tip_radius: float,
    reference_depth: float,
    K: float,
    R_H: float,
    K_c: float,
    x_c: float,
) -> float:
    """Return the elastic force [N]."""
    if x <= 0.0:
        return elastic_force
    X = R_H * math.sqrt(x / tip_radius)
    thin = 1.0 + X * (1.133 + X * (1.283 + X * (0.769 + X * 0.0975)))
    beyond = max(x / reference_depth - x_c, 0.0)
    return elastic_force * thin + K_c * K * beyond * math.sqrt(beyond)


EFFECT = Effect(
    name="layer_over_core",
    summary="the soft layer is thin, and its core is felt",
    cites=("DimitriadisEtAl2002",),
    parameters=(
        Parameter("R_H", "1", 1.0, 1.0, 0.0, 20.0, "tip radius over thickness of the layer", null=0.0),
        Parameter(
            "K_c", "1", 0.5, 1.0, 0.0, 1e3, "force of the core x_ref beyond x_c, over K", null=0.0, of="K"
        ),
        Parameter("x_c", "1", 1.5, 0.5, 0.0, 10.0, "depth at which the core is met, in x_ref", of="x_ref"),
    ),
    hooks=(hook(elastic),),
    confounded=("exponential_stiffness", "power_law_stiffness"),
    experiment="deep press, to a third of the layer",
)
