"""Rate stiffening: while loading, ``N *= 1 + r log10(1 + v / v_0)``, ``v = d delta / dt``.

Thermally activated flow makes the force grow with the logarithm of the speed, [Eyring1936]_. No set of
relaxation branches does that over many decades of speed, and only on loading. ``v_0 = v_r x_ref``.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def force(force: float, speed: float, reference_depth: float, r_v: float, v_r: float) -> float:
    """Return the force [N]."""
    if speed <= 0.0 or r_v == 0.0:
        return force
    return force * (1.0 + r_v * math.log10(1.0 + speed / (v_r * reference_depth)))


EFFECT = Effect(
    name="rate_stiffening",
    summary="the force while loading grows with the logarithm of the speed",
    residual="loading curves at different speeds differ by a factor, unloading curves do not",
    cites=("Eyring1936",),
    parameters=(
        Parameter("r_v", "1", 0.06, 0.05, -0.2, 0.5, "growth of the force per decade of speed", null=0.0),
        Parameter(
            "v_r", "1/s", 0.2, 0.7, 1e-4, 1e4, "speed of onset, x_ref/s", transform="log", of="x_ref/s"
        ),
    ),
    hooks=(hook(force),),
    confounded=("fast_damping", "second_relaxation"),
    experiment="triangles over three decades of speed",
)
