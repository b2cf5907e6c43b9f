"""The least normal force that holds a load: where the load, normalised by it, touches the limit surface.

    gauge(k(N), f_t/(mu N), m_n/(mu N a(N))) = 1 - margin

The gauge falls as N grows, as long as N a(N) grows, so there is one solution.
"""

import math
from collections.abc import Callable

from scipy.optimize import brentq

from vegrip.contact.domain import not_negative, positive
from vegrip.contact.limit_surface import fast
from vegrip.contact.limit_surface.area import Contact, LawOfForce, PowerLawContact
from vegrip.errors import DomainError

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
