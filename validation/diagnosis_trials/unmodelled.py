"""Effects that are in no catalogue; ``shows`` names the variables over which the misfit is a curve."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from vegrip.virtual.hidden import HIDDEN, Clocked, Hidden, fresh, lasting


@dataclass
class Cogging(Hidden):
    """A force that repeats with the position of the drive, as that of a magnet or a toothed rack."""

    shows: ClassVar[frozenset[str]] = frozenset({"displacement"})
    force: float = 0.03  # [N]
    period: float = 5e-4  # [m]

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        return shown + self.force * math.sin(2.0 * math.pi * drive / self.period)


@dataclass
class Magnet(Hidden):
    """An attraction that is felt through the gap, before anything touches."""

    shows: ClassVar[frozenset[str]] = frozenset({"displacement", "contact", "time_in_contact"})
    force: float = 0.06  # [N] at touch
    reach: float = 1.5e-4  # [m]

    def pull(self, x: float) -> float:
        return self.force / (1.0 + max(-x, 0.0) / self.reach) ** 4


@dataclass
class DayAndNight(Clocked):
    """Stiffness that comes and goes with the hour."""

    shows: ClassVar[frozenset[str]] = frozenset({"time"})
    share: float = 0.03  # [-]
    period: float = 150.0  # [s]

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 + self.share * math.sin(2.0 * math.pi * self.time_passed / self.period))


@dataclass
class Crack(Clocked):
    """At some moment something in the tip gives way, and it is softer from then on."""

    shows: ClassVar[frozenset[str]] = frozenset({"time"})
    share: float = 0.06  # [-]
    at: float = 220.0  # [s] of the session

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 - self.share) if self.time_passed > self.at else force


@dataclass
class TransferFilm(Clocked):
    """What the tip leaves on the counter-surface makes it more slippery, episode by episode."""

    shows: ClassVar[frozenset[str]] = frozenset({"time"})
    loss: float = 0.25  # [-] in the end
    time: float = 150.0  # [s]

    def friction(self, mu: float, force: float, speed: float) -> float:
        return mu * (1.0 - self.loss * -math.expm1(-self.time_passed / self.time))


@dataclass
class ShearShrinking(Hidden):
    """The contact shrinks under a tangential load."""

    shows: ClassVar[frozenset[str]] = frozenset({"tangential_force"})
    share: float = 0.15  # [-] of the radius at slip
    friction_at: float = 0.8  # [-] tangential over normal force at slip
    _used: float = fresh()

    def radius(self, a: float, x: float, tip_radius: float) -> float:
        return a * (1.0 - self.share * min(self._used, 1.0) ** 2)

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        self._used = tangential / (self.friction_at * shown) if shown > 0.0 else 0.0
        return shown


@dataclass
class SpeedBand(Hidden):
    """A drive that hums in a band of speeds and adds its force there, whichever way it goes."""

    shows: ClassVar[frozenset[str]] = frozenset({"speed"})
    force: float = 0.05  # [N]
    speed: float = 4e-3  # [m/s] in the middle of the band
    width: float = 0.5  # of ln speed
    _before: float = fresh()

    def sensed(self, shown: float, tangential: float, drive: float, dt: float) -> float:
        speed = abs(drive - self._before) / dt
        self._before = drive
        if speed < 1e-9:
            return shown
        return shown + self.force * math.exp(-((math.log(speed / self.speed) / self.width) ** 2))


@dataclass
class WarmPeak(Hidden):
    """Stiffest at one temperature, softer on both sides of it: a phase that freezes and melts."""

    shows: ClassVar[frozenset[str]] = frozenset({"temperature"})
    share: float = 0.04  # [-]
    peak: float = 26.0  # [degrees Celsius]
    width: float = 1.5  # [K]
    _temperature: float = lasting(22.0)

    def warmed(self, temperature: float) -> None:
        self._temperature = temperature

    def elastic(self, force: float, x: float) -> float:
        return force * (1.0 + self.share * math.exp(-(((self._temperature - self.peak) / self.width) ** 2)))


UNMODELLED: Mapping[str, Any] = {
    "cogging": Cogging,
    "magnet": Magnet,
    "day_and_night": DayAndNight,
    "crack": Crack,
    "transfer_film": TransferFilm,
    "shear_shrinking": ShearShrinking,
    "speed_band": SpeedBand,
    "warm_peak": WarmPeak,
}
"""By the names of ``amounts.py``."""

EVERY: Mapping[str, type[Hidden]] = {**HIDDEN, **UNMODELLED}
