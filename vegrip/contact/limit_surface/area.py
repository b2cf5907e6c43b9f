"""How contact radius and pressure exponent go with the normal force: what a stronger grip changes."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from vegrip.contact.coupling import exponent_after_creep
from vegrip.contact.domain import positive
from vegrip.contact.elastic import PowerStiffness
from vegrip.contact.limit_surface.reference import exponent
from vegrip.errors import DomainError


@dataclass(frozen=True, slots=True)
class PowerLawContact:
    """a = radius (N/at)^radius_power, k = exponent (N/at)^exponent_power; powers 0 are a constant contact.

    A fingertip held at constant indentation has constant area: both powers 0. One pressed harder follows
    :func:`geometric_contact`. Good for 0 < N <= greatest.
    """

    radius: float  # [m] at the normal force `at`
    exponent: float  # [-] in [1, inf] at the normal force `at`
    at: float = 1.0  # [N]
    radius_power: float = 0.0
    exponent_power: float = 0.0
    greatest: float = math.inf  # [N]

    def __post_init__(self) -> None:
        positive("contact radius", self.radius, "m")
        positive("normal force of the contact radius", self.at, "N")
        positive("greatest normal force", self.greatest, "N")
        exponent(self.exponent)
        if not self.radius_power > -1.0:
            raise DomainError(f"a contact radius that falls as N^{self.radius_power:g} has no least force")


@dataclass(frozen=True, slots=True)
class LawOfForce:
    """Any a(N) [m] and k(N), given as functions, for 0 < N <= greatest; a must not fall faster than 1/N."""

    radius: Callable[[float], float]
    exponent: Callable[[float], float]
    greatest: float = math.inf  # [N]


Contact = PowerLawContact | LawOfForce


def geometric_contact(
    R: float, stiffness: PowerStiffness, k: float = 2.0, creep: float = 1.0
) -> PowerLawContact:
    """Contact of a fingertip of radius R [m] pressed on a flat, by its stiffness and the geometric radius.

    a = sqrt(2 R delta h), eq. (33) of [TiezziKao2007]_, with delta(N) of eq. (29), so that a goes as
    N^(1/(2b+2)). k is the exponent at first; after creep by the ratio h (``creep``) at constant load it
    follows C_k = C_k0/h, eq. (36). Holds until the indentation is R.
    """
    at = 1.0
    return PowerLawContact(
        radius=math.sqrt(2.0 * positive("fingertip radius", R, "m") * stiffness.indentation(at) * creep),
        exponent=k if creep == 1.0 else float(exponent_after_creep(creep, k).k),
        at=at,
        radius_power=0.5 / (stiffness.b + 1.0),
        greatest=float(stiffness.force(R / creep)),
    )
