"""Relaxation that depends on depth: all amplitudes times ``1 + beta (x / x_ref - 1)``.

Fung's law separates depth and time, ``N = N_e(delta) g(t)`` ([TiezziKao2007]_, eq. (10)); in many soft
materials a deeper indentation relaxes by another fraction. The depth may be the present one or that at
which what relaxes was loaded: the functions h_1 and h_2 of [Schapery1969]_. A share h of beta belongs to the
second,

    ``N = N_e - c (1 + (1 - h) beta s) z - c h beta z_s``

    ``s = x / x_ref - 1``,   ``dz_s/dt = nu (s N_e - z_s)``

for the first branch; further ones feel the present depth. The factor stays above 0 and stops growing at
``x = R``, where the indentation itself stops making sense.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.effects.relaxation import branch
from vegrip.parameters import Parameter


def deeper(x: float, reference_depth: float, tip_radius: float) -> float:
    """Return by how much x is deeper than x_ref, in x_ref."""
    return min(max(x, 0.0), tip_radius) / reference_depth - 1.0


def elastic(
    relaxation_strength: float, x: float, reference_depth: float, tip_radius: float, beta_x: float, h_x: float
) -> float:
    """Return the factor on the amplitudes of all branches."""
    now = (1.0 - h_x) * beta_x * deeper(x, reference_depth, tip_radius)
    return relaxation_strength * max(1.0 + now, 0.0)


def force(
    force: float,
    elastic_force: float,
    x: float,
    dt: float,
    reference_depth: float,
    tip_radius: float,
    relaxation_rate: float,
    c1: float,
    nu1: float,
    beta_x: float,
    h_x: float,
    z_s: float,
    N_s: float,
) -> tuple[float, float, float]:
    """Return the force [N], what has relaxed at the depths of loading [N], and what it tends to [N]."""
    loaded = deeper(x, reference_depth, tip_radius) * elastic_force
    z_s = branch(z_s, loaded, N_s, relaxation_rate * nu1, dt)
    return force - h_x * beta_x * c1 * z_s, z_s, loaded


EFFECT = Effect(
    name="nonseparable_relaxation",
    summary="deeper indentations relax by another fraction",
    residual="normalised holds at different depths differ in amplitude",
    cites=("Schapery1969",),
    parameters=(
        Parameter(
            "beta_x", "1", 0.2, 0.2, -1.0, 1.0, "growth of the relaxing fraction per x_ref of depth", null=0.0
        ),
        Parameter("h_x", "1", 0.0, 0.5, 0.0, 1.0, "share of it that the depth at loading decides"),
    ),
    states=(
        State("z_s", "N", "what has relaxed at the depths of loading", high="elastic_force"),
        State("N_s", "N", "what it tends to"),
    ),
    hooks=(hook(elastic, gives="relaxation_strength"), hook(force)),
    confounded=("poroelastic_drainage", "series_compliance"),
    experiment="holds of equal length at three depths; growing triangles",
)
