"""Contact radius from geometry: ``a = sqrt(2 R x - x^2)``, [TiezziKao2007]_, eq. (1).

A sphere of radius R cut at depth x. Hertz gives ``a^2 = R x``, half of it: soft tips lie between.
"""

import math

from vegrip.effects.contract import Effect, hook


def area(x: float, tip_radius: float) -> float:
    """Return the contact radius [m]; past the equator (x > R) it stays R."""
    if x <= 0.0:
        return 0.0
    if x >= tip_radius:
        return tip_radius
    return math.sqrt((2.0 * tip_radius - x) * x)


EFFECT = Effect(
    name="geometric_radius",
    summary="the contact circle is where the plane cuts the undeformed sphere",
    cites=("TiezziKao2007",),
    hooks=(hook(area),),
)
