"""Exponential stiffness: ``N_e *= (e^s - 1) / s``, ``s = b x / x_ref``.

With p = 1 this is the exponential law of [TiezziKao2007]_, eq. (13), ``(m / b') (e^(b' x) - 1)`` with ``b'
= b / x_ref`` and ``m = K / x_ref``, Fung's law of tissue ([Fung1993]_, chapter 7). Written as a factor on
the power law it holds both laws of the paper, so that one can be distinguished from the other by its value.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter

STEEPEST = 50.0  # beyond e^50 no contact goes, and floating point would overflow


def elastic(elastic_force: float, x: float, reference_depth: float, b_x: float) -> float:
    """Return the elastic force [N]."""
    s = min(b_x * max(x, 0.0) / reference_depth, STEEPEST)
    if s < 1e-9:
        return elastic_force * (1.0 + 0.5 * s)
    return elastic_force * (math.expm1(s) / s)


EFFECT = Effect(
    name="exponential_stiffness",
    summary="the stiffness grows exponentially with depth",
    residual="S over depth, the same at all rates",
    cites=("TiezziKao2007", "Fung1993"),
    parameters=(Parameter("b_x", "1", 0.8, 0.7, 0.0, 20.0, "growth of ln stiffness per x_ref", null=0.0),),
    hooks=(hook(elastic),),
    confounded=("layer_over_core", "second_contact", "power_law_stiffness"),
    experiment="slow ramp over the full range of depth",
)
