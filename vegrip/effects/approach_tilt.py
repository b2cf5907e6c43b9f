"""Tilt of the approach: ``y = N + b delta``, b in K per x_ref, in air as in contact.

A spring beside the contact, a cable or a flexure, or a path at an angle to the sensor's axis adds a force
that grows with the position of the drive: a sensitivity to another quantity, [Fraden2016]_, and the slope
in the baseline of force curves. The zero of the force takes up where it starts.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def sense(sensed_force: float, delta: float, reference_depth: float, K: float, b_h: float) -> float:
    """Return what the sensor shows [N]."""
    return sensed_force + b_h * K * delta / reference_depth


EFFECT = Effect(
    name="approach_tilt",
    summary="the force grows with the position of the drive, in air as in contact",
    residual="as the position, in air too",
    cites=("Fraden2016",),
    parameters=(
        Parameter(
            "b_h", "1", 0.02, 0.02, -1.0, 1.0, "force over K at a stroke of x_ref", null=0.0, of="K/x_ref"
        ),
    ),
    hooks=(hook(sense),),
    confounded=("force_drift",),
    in_air=True,
    experiment="approach in air at two speeds",
)
