"""Cross-talk: the normal channel also shows a part of the tangential force, ``y = N + c f``.

The magnitude f of the tangential force; a gain error ``y = (1 + e) N`` is not here, it cannot be
distinguished from K.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def sense(sensed_force: float, tangential_force: float, c_f: float) -> float:
    """Return what the sensor shows [N]."""
    return sensed_force + c_f * tangential_force


EFFECT = Effect(
    name="cross_talk",
    summary="the normal force sensor also feels the tangential force",
    residual="as the tangential force",
    cites=("BicchiSalisburyBrock1993",),
    parameters=(Parameter("c_f", "1", 0.01, 0.02, -0.5, 0.5, "share of the tangential force", null=0.0),),
    hooks=(hook(sense),),
    confounded=("inclination",),
    experiment="tangential loading at a constant normal load; dead weights",
)
