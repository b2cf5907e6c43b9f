"""Coulomb friction: ``mu`` does not depend on load, speed or time. [TiezziKao2007]_, eq. (53)-(56)."""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def friction(mu: float) -> float:
    """Return the friction coefficient."""
    return mu


EFFECT = Effect(
    name="coulomb_friction",
    summary="traction at slip is mu times the pressure",
    cites=("TiezziKao2007",),
    parameters=(
        Parameter("mu", "1", 0.7, 0.4, 0.01, 20.0, "friction coefficient", transform="log", learn=True),
    ),
    hooks=(hook(friction),),
)
