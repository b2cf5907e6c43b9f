"""Contact radius law: ``a^2 = kappa R x - chi x^2``.

The geometric cut of [TiezziKao2007]_, eq. (1), has ``kappa = 2, chi = 0`` to first order and ``chi = 1``
exactly; a half-space gives ``kappa = 1``, [Hertz1882]_. What swells at the edge of a soft tip adds to kappa,
so it lies between the two or above. K hides it from force and displacement: only a measured radius, or a
torque at slip together with a force at slip, can show it.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter


def area(contact_radius: float, x: float, tip_radius: float, kappa: float, chi: float) -> float:
    """Return the contact radius [m]; ``contact_radius`` comes in as ``sqrt(2 R x)``, at most R."""
    squared = 0.5 * kappa * contact_radius * contact_radius - chi * max(x, 0.0) ** 2
    return min(math.sqrt(max(squared, 0.0)), tip_radius)


EFFECT = Effect(
    name="contact_radius_law",
    summary="the contact circle is smaller or larger than where the plane cuts the sphere",
    residual="only in radius and torque at slip",
    cites=("TiezziKao2007", "Hertz1882"),
    parameters=(
        Parameter("kappa", "1", 1.4, 0.3, 0.2, 5.0, "2 is geometric, 1 is Hertz", transform="log", null=2.0),
        Parameter("chi", "1", 0.0, 0.3, -2.0, 2.0, "curvature of the cut; 1 is the exact sphere", null=0.0),
    ),
    hooks=(hook(area),),
    channels=("contact_radius", "torque_z"),
    confounded=("pressure_profile",),
    experiment="ink print or camera image at two depths; pure twists to slip",
    imitated_by="a tip of another radius than the {radius:.3g} m stated would show the same",
)
