"""Friction that falls with load: ``mu_eff = mu (N / N_0)^-g``, with ``N_0 = K``.

Rubber shears at a nearly constant strength over its real contact area; an area that grows as ``N^(1 - g)``
gives this law, ``g = 1/3`` for one smooth Hertzian sphere, 0 for a rough surface, [Schallamach1952]_. There
``mu ~ (N / E*)^-1/3``: it is the load over the stiffness that counts. So the reference is K, the elastic
force at x_ref, which makes mu the friction coefficient at that load and keeps the law free of any unit.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter

LIGHTEST = 1e-3  # of K: below it the law is not continued, or mu would be infinite at first touch


def friction(friction: float, force: float, K: float, g_N: float) -> float:
    """Return the friction coefficient."""
    return float(friction * max(force / K, LIGHTEST) ** -g_N)


EFFECT = Effect(
    name="load_dependent_friction",
    summary="the friction coefficient falls with the normal force",
    residual="ratio at slip falls with load",
    cites=("Schallamach1952",),
    parameters=(
        Parameter("g_N", "1", 0.15, 0.12, -0.5, 0.9, "exponent; 1/3 is one smooth sphere", null=0.0),
    ),
    hooks=(hook(friction),),
    channels=("tangential_force", "torque_z"),
    confounded=("friction_ageing",),
    friction_over_load=True,
    experiment="slips at four or more loads after equal holds",
)
