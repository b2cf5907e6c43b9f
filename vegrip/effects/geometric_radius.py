"""Contact radius from geometry: ``a = sqrt(2 R x)``.

[TiezziKao2007]_, eqs. (1) and (32): a sphere of radius R cut at a depth ``x << R``. The exact cut has
``- x^2`` under the root (5 % less at x = R/5); without it a creeps as ``sqrt(h)``, eq. (34), which the
coupling of radius and pressure rests on. Hertz gives ``a^2 = R x``, half of it: soft tips lie between.
"""

import math

from vegrip.effects.contract import Effect, hook


def area(x: float, tip_radius: float) -> float:
    """Return the contact radius [m]; it does not grow beyond R."""
    if x <= 0.0:
        return 0.0
    return min(math.sqrt(2.0 * tip_radius * x), tip_radius)


EFFECT = Effect(
    name="geometric_radius",
    summary="the contact circle is where the plane cuts the undeformed sphere",
    cites=("TiezziKao2007",),
    hooks=(hook(area),),
)
