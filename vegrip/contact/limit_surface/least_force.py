"""The least normal force that holds a load: where the load, normalised by it, touches the limit surface.

    gauge(k(N), f_t/(mu N), m_n/(mu N a(N))) = 1 - margin

The gauge falls as N grows, as long as N a(N) grows, so there is one solution. How contact radius and pressure
exponent go with N, which is what a stronger grip changes, is the :data:`Contact`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from vegrip.contact.coupling import exponent_after_creep
from vegrip.contact.domain import not_negative, positive
from vegrip.contact.elastic import PowerStiffness
from vegrip.contact.limit_surface import fast
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


_POWERS = 400  # 2^-400 N to 2^400 N: every force of which a double can hold the square


def least_normal_force(
    force: float, torque: float, mu: float, contact: Contact, margin: float = 0.0
) -> float:
    """Least normal force [N] that holds a tangential force [N] with a torque about the normal [N m].

    margin in [0, 1) is how far inside the limit surface the load shall stay: gauge <= 1 - margin.
    On the safe side: never below the exact force by more than 2e-8, at most 3e-5 above, relative.

    Raises:
        DomainError: mu <= 0, a load that is not finite, a margin of 1; k(N) below 1; a load that needs more
            than the greatest force the contact law holds for.

    """
    force, torque = abs(force), abs(torque)
    not_negative("tangential force and torque", [force, torque])
    if not (math.isfinite(force) and math.isfinite(torque) and 0.0 <= margin < 1.0):
        raise DomainError("the load must be finite and the margin in 0 .. 1, 1 excluded")
    grip = float(positive("friction coefficient", mu)) * (1.0 - margin)
    if force == torque == 0.0:
        return 0.0
    if isinstance(contact, PowerLawContact):
        least = _of_power_law(force, torque, grip, contact)
    else:
        least = _of_any_law(force, torque, grip, contact)
    if least > contact.greatest:
        raise DomainError(f"the load needs {least:g} N; the contact law holds up to {contact.greatest:g} N")
    return least


def _of_power_law(force: float, torque: float, grip: float, contact: PowerLawContact) -> float:
    least = fast.least_normal_force(
        force,
        torque,
        grip,
        contact.radius,
        contact.exponent,
        contact.at,
        contact.radius_power,
        contact.exponent_power,
    )
    if math.isnan(least):
        raise DomainError("no least normal force: the pressure exponent falls below 1 on the way to it")
    return least


def _of_any_law(force: float, torque: float, grip: float, contact: LawOfForce) -> float:
    from scipy.optimize import brentq  # noqa: PLC0415 (slow to import)

    def excess(log2_force: float) -> float:
        """Logarithm of the gauge, which falls as the normal force grows."""
        N = 2.0**log2_force
        k, a = contact.exponent(N), contact.radius(N)
        if not (k >= 1.0 and a > 0.0):
            raise DomainError(f"at {N:g} N the contact law gives exponent {k:g} and radius {a:g} m")
        return math.log(fast.gauge(k, force / (grip * N), torque / (grip * N * a)))

    low, high = _bracket(excess, math.log2(contact.greatest))
    return float(2.0 ** brentq(excess, low, high, xtol=1e-14, rtol=1e-14))


def _bracket(excess: Callable[[float], float], top: float) -> tuple[float, float]:
    """Two forces, as powers of 2, with the solution between them: steps of a factor 2 from 1 N or the top."""
    low = high = min(0.0, top)
    while excess(low) < 0.0:
        low -= 1.0
        if low < -_POWERS:
            raise DomainError("under this contact law no normal force is too small for the load")
    while excess(high) > 0.0:
        if high >= min(top, _POWERS):
            raise DomainError(f"the load needs more than {2.0**high:g} N, the greatest the contact law gives")
        low, high = high, min(high + 1.0, top)
    return low, high
