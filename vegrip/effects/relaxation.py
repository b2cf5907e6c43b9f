"""Quasi-linear viscoelastic relaxation with one time constant.

``N = N_e - z1``, where ``z1``, the force that has relaxed, follows its share of the elastic force,
``dz1/dt = nu1 (c1 N_e - z1)``.

This is the hereditary integral of [TiezziKao2007]_, eq. (20), with the reduced relaxation function of
eq. (15), ``g = c0 + c1 exp(-nu1 t)``, ``c0 + c1 = 1``: its branch is ``q1 = c1 N_e - z1``. In z a correction
of the indentation changes N at once with the instantaneous stiffness, as it must. And z1 is a force, not the
elastic force that it follows: N is then linear in the state, where ``c1 z1`` is a product of two unknowns,
which made an estimator sure of a wrong c1.
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def branch(z: float, elastic_force: float, elastic_before: float, rate: float, dt: float) -> float:
    """Return z after dt [s], exact for an elastic force that is linear in time within the step.

    ``z+ = E z + (1-E) N_e0 + (1-phi) (N_e1 - N_e0)``, ``E = exp(-nu dt)``, ``phi = (1-E) / (nu dt)``.
    """
    h = rate * dt
    if h <= 0.0:
        return z
    lost = -math.expm1(-h)  # 1 - E without cancellation
    return z + lost * (elastic_before - z) + (1.0 - lost / h) * (elastic_force - elastic_before)


def force(
    force: float,
    elastic_force: float,
    elastic_before: float,
    dt: float,
    relaxation_rate: float,
    relaxation_strength: float,
    c1: float,
    nu1: float,
    z1: float,
) -> tuple[float, float]:
    """Return the force [N] and the force z1 [N] that has relaxed."""
    z1 = branch(z1, c1 * elastic_force, c1 * elastic_before, relaxation_rate * nu1, dt)
    return force - relaxation_strength * z1, z1


EFFECT = Effect(
    name="relaxation",
    summary="under a constant indentation the force falls exponentially by the fraction c1",
    cites=("TiezziKao2007",),
    parameters=(
        Parameter(
            "c1", "1", 0.3, 0.1, 0.0, 0.95, "fraction of the force that relaxes", learn=True, drift=3e-4
        ),
        Parameter("nu1", "1/s", 3.1, 0.3, 1e-4, 1e4, "rate of relaxation", transform="log", learn=True),
    ),
    states=(State("z1", "N", "force that has relaxed", high="elastic_force", share="c1"),),
    hooks=(hook(force),),
)
