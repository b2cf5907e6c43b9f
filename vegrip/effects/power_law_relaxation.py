"""Relaxation over many decades: ``N = ... - c_P sum_i w_i z_i``, ``w_i ~ nu_i^alpha``, ``sum_i w_i = 1``.

Power-law materials (cells, tissue, gels) have no time constant of their own; their relaxation is straight
in log t, or in a double logarithmic plot. A power law ``t^-alpha`` has the spectrum ``nu^alpha`` over ln
nu, [BonfantiKaplanCharrasKabla2020]_; here it is seven branches from 0.01 to 100 1/s, two thirds of a
decade apart, ``dz_i/dt = nu_i (N_e - z_i)``. So spaced the step response is within 0.3 % of c_P of the
continuous spectrum from 0.1 to 10 s for any alpha in 0 .. 0.3; with one branch per decade it would be 1.3
%. ``alpha = 0`` relaxes evenly per decade, as log t.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.effects.relaxation import branch
from vegrip.parameters import Parameter

SLOWEST = 0.01  # [1/s]
RATIO = 4.641588833612779  # 10^(2/3)


def force(
    force: float,
    elastic_force: float,
    elastic_before: float,
    dt: float,
    relaxation_rate: float,
    relaxation_strength: float,
    c_P: float,
    alpha_P: float,
    zP1: float,
    zP2: float,
    zP3: float,
    zP4: float,
    zP5: float,
    zP6: float,
    zP7: float,
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return the force [N] and the relaxed force of each branch [N]."""
    nu = relaxation_rate * SLOWEST
    zP1 = branch(zP1, elastic_force, elastic_before, nu, dt)
    nu = nu * RATIO
    zP2 = branch(zP2, elastic_force, elastic_before, nu, dt)
    nu = nu * RATIO
    zP3 = branch(zP3, elastic_force, elastic_before, nu, dt)
    nu = nu * RATIO
    zP4 = branch(zP4, elastic_force, elastic_before, nu, dt)
    nu = nu * RATIO
    zP5 = branch(zP5, elastic_force, elastic_before, nu, dt)
    nu = nu * RATIO
    zP6 = branch(zP6, elastic_force, elastic_before, nu, dt)
    nu = nu * RATIO
    zP7 = branch(zP7, elastic_force, elastic_before, nu, dt)
    w = RATIO**alpha_P  # weight of a branch over that of its slower neighbour
    total = 1.0 + w * (1.0 + w * (1.0 + w * (1.0 + w * (1.0 + w * (1.0 + w)))))
    relaxed = zP1 + w * (zP2 + w * (zP3 + w * (zP4 + w * (zP5 + w * (zP6 + w * zP7)))))
    return force - relaxation_strength * c_P * relaxed / total, zP1, zP2, zP3, zP4, zP5, zP6, zP7


def _states() -> tuple[State, ...]:
    doc = "elastic force as the branch at {:.2g} 1/s has followed it"
    return tuple(
        State(f"zP{i + 1}", "N", doc.format(SLOWEST * RATIO**i), high="elastic_force") for i in range(7)
    )


EFFECT = Effect(
    name="power_law_relaxation",
    summary="under a constant indentation the force falls by the same step in every decade of time",
    residual="straight in log t over decades of a hold",
    cites=("BonfantiKaplanCharrasKabla2020",),
    parameters=(
        Parameter(
            "c_P", "1", 0.15, 0.1, 0.0, 0.95, "fraction of the force that relaxes in 0.01 .. 100 s", null=0.0
        ),
        Parameter(
            "alpha_P", "1", 0.05, 0.1, -0.5, 0.9, "exponent; more than 0 relaxes more in the beginning"
        ),
    ),
    states=_states(),
    hooks=(hook(force),),
    confounded=("second_relaxation",),
    experiment="hold over three decades of time; sine sweep",
    expensive=True,
    companions=("second_relaxation",),
)
