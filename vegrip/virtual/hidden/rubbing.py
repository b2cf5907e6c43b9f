"""Friction that is not a constant."""

import math
from dataclasses import dataclass, field

from vegrip.virtual.hidden.base import Hidden


@dataclass
class LoadDependentFriction(Hidden):
    """A power of the normal force."""

    exponent: float = 0.15  # [-] by which it falls
    at: float = 1.0  # [N] where it is the nominal one

    def friction(self, mu: float, force: float, speed: float) -> float:
        """Return the friction coefficient."""
        return float(mu * (max(force, 1e-3 * self.at) / self.at) ** -self.exponent)


@dataclass
class RateDependentFriction(Hidden):
    """Static friction that gives way to a kinetic one, which grows with the logarithm of the speed."""

    kinetic: float = 0.85  # [-] over static
    stribeck: float = 1e-3  # [m/s]
    growth: float = 0.03  # [-] per e-fold
    slow: float = 1e-4  # [m/s] where the growth begins

    def friction(self, mu: float, force: float, speed: float) -> float:
        """Return the friction coefficient."""
        ratio = speed / self.stribeck
        falling = self.kinetic + (1.0 - self.kinetic) * math.exp(-ratio * ratio)
        return mu * (falling + self.growth * math.log(1.0 + speed / self.slow))


@dataclass
class FrictionAgeing(Hidden):
    """Friction grows with the logarithm of the age of the contact; sliding renews it."""

    growth: float = 0.05  # [-] per e-fold
    time: float = 0.1  # [s] where it begins
    distance: float = 1e-5  # [m] of slip that renews the contact
    _age: float = field(default=0.0, init=False)

    def start(self, pause: float) -> None:
        """Begin with no contact."""
        self._age = 0.0

    def friction(self, mu: float, force: float, speed: float) -> float:
        """Return the friction coefficient."""
        return mu * (1.0 + self.growth * math.log(1.0 + self._age / self.time))

    def rubbed(self, force: float, speed: float, dt: float) -> None:
        """Grow older, or younger by sliding."""
        kept = 1.0 - min(speed * dt / self.distance, 1.0)
        self._age = (self._age * kept + dt) if force > 0.0 else 0.0


@dataclass
class WetContact(Hidden):
    """A film that is squeezed out while the contact lasts."""

    loss: float = 0.3  # [-] of friction at first touch
    time: float = 1.0  # [s]
    _film: float = field(default=1.0, init=False)

    def start(self, pause: float) -> None:
        """Begin wet."""
        self._film = 1.0

    def friction(self, mu: float, force: float, speed: float) -> float:
        """Return the friction coefficient."""
        return mu * (1.0 - self.loss * self._film)

    def rubbed(self, force: float, speed: float, dt: float) -> None:
        """Squeeze, or wet again."""
        self._film = self._film * (1.0 - dt / self.time) if force > 0.0 else 1.0
