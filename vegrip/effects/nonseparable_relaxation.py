"""Relaxation that depends on depth: all amplitudes times ``1 + beta (x / x_ref - 1)``.

Fung's law separates depth and time, ``N = N_e(delta) g(t)`` ([TiezziKao2007]_, eq. (10)); in many soft
materials a deeper indentation relaxes by another fraction, [Schapery1969]_. The factor stays above 0 and
stops growing at ``x = R``, where the indentation itself stops making sense.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def elastic(
    relaxation_strength: float, x: float, reference_depth: float, tip_radius: float, beta_x: float
) -> float:
    """Return the factor on the amplitudes of all branches."""
    depth = min(max(x, 0.0), tip_radius) / reference_depth
    return relaxation_strength * max(1.0 + beta_x * (depth - 1.0), 0.0)


EFFECT = Effect(
    name="nonseparable_relaxation",
    summary="deeper indentations relax by another fraction",
    cites=("Schapery1969",),
    parameters=(
        Parameter(
            "beta_x", "1", 0.2, 0.2, -1.0, 1.0, "growth of the relaxing fraction per x_ref of depth", null=0.0
        ),
    ),
    hooks=(hook(elastic, gives="relaxation_strength"),),
    confounded=("poroelastic_drainage", "series_compliance"),
    experiment="holds of equal length at three depths; growing triangles",
)
