"""Effects that are in no catalogue; ``shows`` names the variables over which the misfit is a curve."""

import math
from dataclasses import dataclass, field
from typing import ClassVar

from vegrip.virtual.hidden.base import Hidden


class Unknown(Hidden):
    """An effect that no catalogue has."""

    shows: ClassVar[frozenset[str]] = frozenset()


@dataclass
class Cogging(Unknown):
    """A force that repeats with the position of the drive, as that of a magnet or a toothed rack."""

    shows: ClassVar[frozenset[str]] = frozenset({"displacement"})
    force: float = 0.03  # [N]
    period: float = 5e-4  # [m]
    _at: float = field(default=0.0, init=False)

    def moved(self, position: float) -> float:
        """Look where the drive stands."""
        self._at = position
        return position

    def drive(self, mount: float) -> float:
        """Look where the drive stands."""
        self._at = mount
        return mount

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the force with the ripple."""
        return shown + self.force * math.sin(2.0 * math.pi * self._at / self.period)


@dataclass
class Magnet(Unknown):
    """An attraction that is felt through the gap, before anything touches."""

    shows: ClassVar[frozenset[str]] = frozenset({"displacement", "contact", "time_in_contact"})
    force: float = 0.06  # [N] at touch
    reach: float = 1.5e-4  # [m]

    def pull(self, x: float) -> float:
        """Return the pull [N]."""
        return self.force / (1.0 + max(-x, 0.0) / self.reach) ** 4


@dataclass
class _Clocked(Unknown):
    """Knows how late it is in the session."""

    _time: float = field(default=0.0, init=False)
    _started: bool = field(default=False, init=False)

    def start(self, pause: float) -> None:
        """Let the pause pass."""
        self._time += pause if self._started else 0.0
        self._started = True

    def remember(self, x: float, force: float, dt: float) -> None:
        """Let the step pass."""
        self._time += dt


@dataclass
class DayAndNight(_Clocked):
    """Stiffness that comes and goes with the hour."""

    shows: ClassVar[frozenset[str]] = frozenset({"time"})
    share: float = 0.03  # [-]
    period: float = 150.0  # [s]

    def elastic(self, force: float, x: float) -> float:
        """Return the force of this hour."""
        return force * (1.0 + self.share * math.sin(2.0 * math.pi * self._time / self.period))


@dataclass
class Crack(_Clocked):
    """At some moment something in the tip gives way, and it is softer from then on."""

    shows: ClassVar[frozenset[str]] = frozenset({"time"})
    share: float = 0.06  # [-]
    at: float = 220.0  # [s] of the session

    def elastic(self, force: float, x: float) -> float:
        """Return the force of the whole tip, or of the cracked one."""
        return force * (1.0 - self.share) if self._time > self.at else force


@dataclass
class TransferFilm(_Clocked):
    """What the tip leaves on the counter-surface makes it more slippery, episode by episode."""

    shows: ClassVar[frozenset[str]] = frozenset({"time"})
    loss: float = 0.25  # [-] in the end
    time: float = 150.0  # [s]

    def friction(self, mu: float, force: float, speed: float) -> float:
        """Return the friction coefficient."""
        return mu * (1.0 - self.loss * -math.expm1(-self._time / self.time))


@dataclass
class ShearShrinking(Unknown):
    """The contact shrinks under a tangential load."""

    shows: ClassVar[frozenset[str]] = frozenset({"tangential_force"})
    share: float = 0.15  # [-] of the radius at slip
    friction_at: float = 0.8  # [-] tangential over normal force at slip
    _used: float = field(default=0.0, init=False)

    def radius(self, a: float, x: float, tip_radius: float) -> float:
        """Return the radius of what is left."""
        return a * (1.0 - self.share * min(self._used, 1.0) ** 2)

    def start(self, pause: float) -> None:
        """Begin without load."""
        self._used = 0.0

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Look at the load of this step."""
        self._used = tangential / (self.friction_at * shown) if shown > 0.0 else 0.0
        return shown


@dataclass
class SpeedBand(Unknown):
    """A drive that hums in a band of speeds and adds its force there, whichever way it goes."""

    shows: ClassVar[frozenset[str]] = frozenset({"speed"})
    force: float = 0.05  # [N]
    speed: float = 4e-3  # [m/s] in the middle of the band
    width: float = 0.5  # of ln speed
    _before: float = field(default=0.0, init=False)
    _at: float = field(default=0.0, init=False)

    def start(self, pause: float) -> None:
        """Begin at rest."""
        self._before = self._at = 0.0

    def moved(self, position: float) -> float:
        """Look where the drive stands."""
        self._at = position
        return position

    def drive(self, mount: float) -> float:
        """Look where the drive stands."""
        self._at = mount
        return mount

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the force with what the drive adds."""
        speed = abs(self._at - self._before) / dt
        self._before = self._at
        if speed < 1e-9:
            return shown
        return shown + self.force * math.exp(-((math.log(speed / self.speed) / self.width) ** 2))


@dataclass
class WarmPeak(Unknown):
    """Stiffest at one temperature, softer on both sides of it: a phase that freezes and melts."""

    shows: ClassVar[frozenset[str]] = frozenset({"temperature"})
    share: float = 0.04  # [-]
    peak: float = 26.0  # [degrees Celsius]
    width: float = 1.5  # [K]
    _temperature: float = field(default=22.0, init=False)

    def warmed(self, temperature: float) -> None:
        """Take the temperature of the coming episode."""
        self._temperature = temperature

    def elastic(self, force: float, x: float) -> float:
        """Return the force."""
        return force * (1.0 + self.share * math.exp(-(((self._temperature - self.peak) / self.width) ** 2)))
