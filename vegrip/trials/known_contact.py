"""An estimator that knows the truth of its contact: the bound of what any of them can reach."""

import math
from collections.abc import Callable
from typing import Protocol

from vegrip.contact.limit_surface.fast import least_normal_force
from vegrip.hand_sample import HandSample
from vegrip.messages import ContactEstimate, Estimate, FingertipState, ModelHealth, SlipMargin
from vegrip.types import Floats

HERTZ_POWER = 1.0 / 3.0

LeastForce = Callable[[float, float, float, float, float, float, float], float]
"""What :func:`least_force` is: the limit of a simulated contact, asked for its least normal force [N]."""


class Plant(Protocol):
    """A simulated hand that holds an object and knows the truth; ours is ``vegrip.virtual.VirtualHand``."""

    @property
    def fingers(self) -> tuple[str, ...]:
        """Their names."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def slips(self) -> int:
        """Slides of a whole patch by more than 0.1 mm, so far."""

    @property
    def largest_micro_slip(self) -> float:
        """The longest shorter slide [m]."""

    @property
    def dropped(self) -> bool:
        """The object is lost."""

    @property
    def friction_exponent(self) -> float:
        """By which friction falls with the normal force [-]."""

    def advance(self, dt: float, commands: Floats) -> list[HandSample]:
        """Go on by ``dt`` [s] under normal forces [N], NaN = none; return the samples on the way."""

    def truths(self) -> Floats:
        """Return the true contacts, in the order of ``vegrip.virtual.hand.TRUTHS``."""

    def contact(self, number: int) -> tuple[float, float, float, float]:
        """Return true normal force [N], friction, contact radius [m] and exponent of a finger."""


def least_force(
    force: float,
    tangential: float,
    torque: float,
    mu: float,
    radius: float,
    exponent: float,
    friction_exponent: float = 0.0,
) -> float:
    """Return the normal force [N] at which a load is on the limit surface.

    Friction ``mu`` and contact ``radius`` [m] are those of the present ``force`` N_0 [N], and go with
    ``(N / N_0)^-g`` and ``(N / N_0)^(1/3)``; without a contact only no load can be carried. In
    ``n = (N / N_0)^(1-g)`` the load is ``f / n`` and ``m / n^(1 + 1/(3(1-g)))``: that of constant friction
    with another power of the radius.
    """
    if not (force > 0.0 and radius > 0.0):
        return 0.0 if tangential + torque == 0.0 else math.inf
    power = 1.0 / (1.0 - friction_exponent)
    plain = least_normal_force(tangential, torque, mu, radius, exponent, force, HERTZ_POWER * power, 0.0)
    least: float = plain * (plain / force) ** (friction_exponent * power)
    return least


class KnownContact:
    """The contact of one finger of a simulated hand, as it is."""

    def __init__(self, hand: Plant, finger: str, least: LeastForce = least_force) -> None:
        self._hand, self._finger, self._number = hand, finger, hand.fingers.index(finger)
        self._least = least
        self.reset()

    @property
    def in_contact(self) -> bool:
        return self._hand.contact(self._number)[0] > 0.0

    @property
    def normal_force(self) -> Estimate:
        return Estimate(self._hand.contact(self._number)[0], 0.0, valid=True, age=0.0)

    def assimilate(self, state: FingertipState) -> None:
        self._stamp = state.stamp
        self._load = math.hypot(state.tangential_force_x, state.tangential_force_y), abs(state.torque_z)

    def contact_estimate(self) -> ContactEstimate:
        force, mu, radius, exponent = (
            Estimate(value, 0.0, valid=True, age=0.0) for value in self._hand.contact(self._number)
        )
        return ContactEstimate(
            self._stamp, self._finger, 0, in_contact=self.in_contact, normal_force=force,
            contact_radius=radius, pressure_exponent=exponent, friction_coefficient=mu,
        )  # fmt: skip

    def slip_margin(self) -> SlipMargin:
        return SlipMargin(self._stamp, self._finger, 0)

    def health(self) -> ModelHealth:
        return ModelHealth(self._stamp, self._finger, 0, nis=1.0, consistent=True)

    def reset_health(self) -> None:
        """Forget nothing."""

    def least_force(
        self,
        margin: float,
        confidence: float,  # noqa: ARG002 (the truth is certain)
        load: tuple[float, float] | None = None,
    ) -> float:
        """Return the least normal force [N] for the wanted margin, under the last load or the given one."""
        force, mu, radius, exponent = self._hand.contact(self._number)
        tangential, torque = self._load if load is None else load
        falls = self._hand.friction_exponent
        return self._least(force, tangential, abs(torque), mu * (1.0 - margin), radius, exponent, falls)

    def reset(self) -> None:
        self._stamp, self._load = 0, (0.0, 0.0)
