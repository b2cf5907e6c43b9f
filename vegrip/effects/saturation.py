"""Saturation of the force sensor: ``y = clip(N, -F, F)``.

F is given by its inverse, ``s = K / F``, so that 0 is a sensor without a limit. Resolution is not here: it
counts as noise.
"""

from collections.abc import Iterator, Mapping

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def sense(sensed_force: float, K: float, s_F: float) -> float:
    """Return what the sensor shows [N]."""
    if s_F <= 0.0:
        return sensed_force
    return min(max(sensed_force, -K / s_F), K / s_F)


def _below_the_greatest_force(values: Mapping[str, float], greatest: float) -> Iterator[dict[str, float]]:
    """Saturations just below the greatest force: at any other a score test sees nothing, or all."""
    if "K" in values:
        for share in (0.98, 0.9):
            yield {"s_F": min(values["K"] / (share * greatest), 1e3)}


EFFECT = Effect(
    name="saturation",
    summary="the force sensor ends at its full scale",
    residual="flat tops",
    cites=("Fraden2016",),
    parameters=(Parameter("s_F", "1", 0.5, 0.5, 0.0, 1e3, "K over full scale", null=0.0),),
    hooks=(hook(sense),),
    confounded=("layer_over_core",),
    experiment="histogram of the force; a lower load",
    kinked=True,
    trials_at=_below_the_greatest_force,
)
