"""A soft layer on a hard core: the thin layer stiffens, and far in the core itself is met.

``N_e *= 1 + 1.133 X + 1.283 X^2 + 0.769 X^3 + 0.0975 X^4``, ``X = sqrt(R x) / H``: a sphere on an
incompressible layer of thickness H bonded to a rigid base, [DimitriadisEtAl2002]_, eq. (10); H enters as R
/ H. Then ``N_e += K_c ((x - x_c) / x_ref)^(3/2)`` beyond the depth x_c, a Hertzian contact of the core
itself. That is a :mod:`second_contact <vegrip.effects.second_contact>`, and stands here too because layer
and core are one body: a deep press into silicone shows both, and a core alone drives p to 2.2 there.
"""

import math
from collections.abc import Iterator, Mapping

from vegrip.effects.contract import Effect, hook
from vegrip.effects.second_contact import depths, pressed
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
    return elastic_force * thin + K_c * K * pressed(x / reference_depth, x_c, 1.5)


def _trials(values: Mapping[str, float], greatest: float) -> Iterator[dict[str, float]]:
    for depth in depths(values, greatest, 0.5, 0.75):
        yield {"R_H": 1.0, "K_c": 0.5, "x_c": depth}
    for depth in depths(values, greatest, 0.3, 0.55, 0.8):  # the core alone, as a second contact
        yield {"R_H": 0.0, "K_c": 0.5, "x_c": depth}


EFFECT = Effect(
    name="layer_over_core",
    summary="the soft layer is thin, and its core is felt",
    residual="grows steeply with depth, at all rates",
    cites=("DimitriadisEtAl2002",),
    parameters=(
        Parameter("R_H", "1", 1.0, 1.0, 0.0, 20.0, "tip radius over thickness of the layer", null=0.0),
        Parameter(
            "K_c", "1", 0.5, 1.0, 0.0, 1e3, "force of the core x_ref beyond x_c, over K", null=0.0, of="K"
        ),
        Parameter("x_c", "1", 1.5, 0.5, 0.0, 10.0, "depth at which the core is met, in x_ref", of="x_ref"),
    ),
    hooks=(hook(elastic),),
    confounded=("exponential_stiffness", "power_law_stiffness", "second_contact"),
    experiment="deep press, to a third of the layer",
    trial_shapes=(("x_c", (0.75, 1.5)),),
    trials_at=_trials,
)
