"""A second relaxation time: ``N = ... - z2``, ``dz2/dt = nu2 (c2 N_e - z2)``.

The second branch of [TiezziKao2007]_, eq. (15). Real soft materials relax over decades of time; one branch
leaves a residual that changes sign within a hold.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.effects.relaxation import branch
from vegrip.parameters import Parameter


def force(
    force: float,
    elastic_force: float,
    elastic_before: float,
    dt: float,
    relaxation_rate: float,
    relaxation_strength: float,
    c2: float,
    nu2: float,
    z2: float,
) -> tuple[float, float]:
    """Return the force [N] and the force z2 [N] that has relaxed."""
    z2 = branch(z2, c2 * elastic_force, c2 * elastic_before, relaxation_rate * nu2, dt)
    return force - relaxation_strength * z2, z2


EFFECT = Effect(
    name="second_relaxation",
    summary="under a constant indentation the force falls further, on a second time scale",
    residual="within a hold of one sign, then of the other",
    cites=("TiezziKao2007",),
    parameters=(
        Parameter(
            "c2",
            "1",
            0.1,
            0.05,
            0.0,
            0.95,
            "fraction of the force that relaxes on the second time scale",
            null=0.0,
            learn=True,
            drift=3e-4,
        ),
        Parameter(
            "nu2", "1/s", 0.2, 0.7, 1e-4, 1e4, "rate of the second relaxation", transform="log", learn=True
        ),
    ),
    states=(State("z2", "N", "force that has relaxed more slowly", high="elastic_force", share="c2"),),
    hooks=(hook(force),),
    confounded=("power_law_relaxation", "poroelastic_drainage", "force_drift"),
    experiment="hold for 5 / nu2 at two depths",
    companions=("power_law_relaxation",),
    trial_shapes=(("nu2", (0.02, 0.06, 0.2, 0.6, 2.0, 8.0, 40.0)),),  # on either side of the first rate
)
