"""Presliding: slip creeps in from the edge, and is felt before the whole contact slides.

``mu_onset = mu [1 - (1 - A)^n]``, ``A = A_s`` while it sticks; ``n = d ln N_e / d ln x``.

Under a tangential load f the rim slips and a circle of radius c sticks. For any axisymmetric contact the
traction is the difference of two pressures ([Jaeger1998]_, [Ciavarella1998]_), so ``f = mu (N - N(c))``; with
``N ~ x^n`` and ``x ~ a^2`` this is ``f / (mu N) = 1 - (c / a)^(2 n)``, which for n = 3/2 is the law of
[Cattaneo1938]_ and [Mindlin1949]_. A is the share ``1 - (c / a)^2`` of the area that has slipped, A_s that
when slip is reported; 1 reports full slip only.

The same theory has ``A = u / u_s``, u the tangential displacement. Before slip is reported u is in no message
and no recording; from then on it is the way that is slid, ``A = A_s + u / u_s``, until the whole contact
slides: at once where u_s is next to nothing.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def creep(force: float, slip_speed: float, dt: float, reference_depth: float, u_p: float) -> float:
    """Return the way slid since slip was felt [x_ref]; nothing while it sticks, or out of contact."""
    if force <= 0.0 or slip_speed == 0.0:
        return 0.0
    return u_p + abs(slip_speed) * dt / reference_depth


def friction(
    friction: float, slip_speed: float, elastic_exponent: float, A_s: float, u_s: float, u_p: float
) -> float:
    """Return the friction coefficient at which slip is reported, or that of sliding."""
    share = A_s if slip_speed == 0.0 else A_s + u_p / u_s
    if share >= 1.0:
        return friction
    return float(friction * (1.0 - (1.0 - share) ** max(elastic_exponent, 1.0)))


EFFECT = Effect(
    name="presliding",
    summary="slip is reported when a part of the contact slips, below the load of full sliding",
    residual="slip is felt below the sliding load",
    cites=("Cattaneo1938", "Mindlin1949", "Jaeger1998", "Ciavarella1998"),
    parameters=(
        Parameter("A_s", "1", 0.8, 0.15, 0.05, 1.0, "share of the area that slips at onset", null=1.0),
        Parameter(
            "u_s", "1", 0.01, 1.5, 1e-6, 10.0, "way that makes all of it slip, in x_ref",
            transform="log", of="x_ref",
        ),
    ),
    states=(State("u_p", "1", "way slid since slip was felt, in x_ref"),),
    hooks=(hook(creep, stage="force", gives=""), hook(friction)),
    channels=("tangential_force",),
    confounded=("rate_dependent_friction", "friction_ageing", "wet_contact"),
    experiment="slow pulls through onset into sliding, and small tangential cycles below half of the limit",
)  # fmt: skip
