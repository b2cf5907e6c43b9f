"""Compliance in series: what carries the fingertip gives way, ``x = delta - C N``.

The displacement is measured behind a mount (finger link, load cell, cantilever) that bends by ``C N``. A
constant C looks like a softer power law; what gives it away is the apparent relaxation that depends on
depth, and the contact radius ([OliverPharr1992]_ on machine compliance). Solved exactly within each step,
so it acts at once and at any C.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def tip(reference_depth: float, K: float, s_C: float) -> float:
    """Return the compliance ``C = s_C x_ref / K`` [m/N]."""
    return s_C * reference_depth / K


EFFECT = Effect(
    name="series_compliance",
    summary="what carries the fingertip bends in proportion to the force",
    residual="almost none in force (K, p and c1 absorb it); relaxation grows with depth; small radius",
    cites=("OliverPharr1992",),
    parameters=(
        Parameter(
            "s_C", "1", 0.05, 0.05, 0.0, 10.0, "bending under the force K, over x_ref", null=0.0, of="x_ref/K"
        ),
    ),
    hooks=(hook(tip, gives="compliance"),),
    channels=("normal_force", "contact_radius"),
    confounded=("power_law_stiffness", "nonseparable_relaxation"),
    experiment="press against a rigid dummy; measure the contact radius; fast deep hold",
    expensive=True,
)
