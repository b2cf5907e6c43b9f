"""Poroelastic drainage: relaxation by flow through the material, ``nu_i ~ (x / x_ref)^-q``.

The fluid leaves over the distance a, so its rate is ``nu = D / a^2`` ([HuZhaoVlassakSuo2010]_); with ``a^2
= 2 R x`` that is q = 1, and q = 0 is viscoelasticity, whose rates know no length. Below a hundredth of
x_ref, and in the air, the rate stays what it is there.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter

SHALLOWEST = 0.01  # [x_ref]


def elastic(relaxation_rate: float, x: float, reference_depth: float, q_D: float) -> float:
    """Return the factor on the rates of all branches."""
    if q_D == 0.0:
        return relaxation_rate
    depth: float = max(x / reference_depth, SHALLOWEST)
    return float(relaxation_rate * depth**-q_D)


EFFECT = Effect(
    name="poroelastic_drainage",
    summary="small contacts relax faster, as fluid has a shorter way out",
    residual="normalised holds at different depths differ in rate",
    cites=("HuZhaoVlassakSuo2010",),
    parameters=(Parameter("q_D", "1", 1.0, 0.5, -0.5, 2.0, "1 = flow over the contact radius", null=0.0),),
    hooks=(hook(elastic, gives="relaxation_rate"),),
    confounded=("nonseparable_relaxation",),
    experiment="holds at 0.5, 1 and 2 x_ref; two tip radii; growing triangles",
)
