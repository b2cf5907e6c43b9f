"""Presliding: slip creeps in from the edge, and is felt before the whole contact slides.

``mu_onset = mu [1 - (1 - A_s)^n]`` while it sticks, mu while it slides; ``n = d ln N_e / d ln x``.

Under a tangential load f the rim slips and a circle of radius c sticks. For any axisymmetric contact the
traction is the difference of two pressures ([Jaeger1998]_, [Ciavarella1998]_), so ``f = mu (N - N(c))``; with
``N ~ x^n`` and ``x ~ a^2`` this is ``f / (mu N) = 1 - (c / a)^(2 n)``, which for n = 3/2 is the law of
[Cattaneo1938]_ and [Mindlin1949]_. A_s is the share ``1 - (c / a)^2`` of the area that has slipped when slip
is reported; 1 reports full slip only.

The tangential displacement ``u = u_s [1 - (1 - f / mu N)^(2/3)]`` of the same theory is in no message and no
recording, and it does not move the limit; it is not computed. What remains is where slip is felt.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def friction(friction: float, slip_speed: float, elastic_exponent: float, A_s: float) -> float:
    """Return the friction coefficient at which slip is reported, or that of sliding."""
    if slip_speed != 0.0 or A_s >= 1.0:
        return friction
    return float(friction * (1.0 - (1.0 - A_s) ** max(elastic_exponent, 1.0)))


EFFECT = Effect(
    name="presliding",
    summary="slip is reported when a part of the contact slips, below the load of full sliding",
    cites=("Cattaneo1938", "Mindlin1949", "Jaeger1998", "Ciavarella1998"),
    parameters=(
        Parameter("A_s", "1", 0.8, 0.15, 0.05, 1.0, "share of the area that slips at onset", null=1.0),
    ),
    hooks=(hook(friction),),
    channels=("tangential_force",),
    confounded=("rate_dependent_friction",),
    experiment="slow pulls through onset into sliding, and small tangential cycles below half of the limit",
)
