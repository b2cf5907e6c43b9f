"""Friction in the guide of the drive: ``y = N + F tanh(v / v_0)``, in air too.

Coulomb friction smoothed over a speed v_0, as is usual for simulation, [ArmstrongDupontCanudas1994]_. F is
in units of K, v_0 in x_ref per second.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def sense(
    sensed_force: float, speed: float, reference_depth: float, K: float, F_g: float, v_g: float
) -> float:
    """Return what the sensor shows [N]."""
    if F_g == 0.0:
        return sensed_force
    return sensed_force + F_g * K * math.tanh(speed / (v_g * reference_depth))


EFFECT = Effect(
    name="guide_friction",
    summary="a friction force follows the direction of the motion, in air as in contact",
    residual="odd in the speed, in air too",
    cites=("ArmstrongDupontCanudas1994",),
    parameters=(
        Parameter("F_g", "1", 0.02, 0.02, -1.0, 1.0, "friction in units of K", null=0.0, of="K"),
        Parameter(
            "v_g", "1/s", 0.05, 1.0, 1e-5, 1e4, "speed of half of it, x_ref/s", transform="log", of="x_ref/s"
        ),
    ),
    hooks=(hook(sense),),
    confounded=("displacement_backlash",),
    in_air=True,
    experiment="strokes in air",
)
