"""A normal force sensor that shows something else than the normal force."""

import math
from dataclasses import dataclass, field

from vegrip.virtual.hidden.base import Hidden

LAG_SUBSTEPS = 8  # steps of the lag within a step of the trial


@dataclass
class SensorLag(Hidden):
    """The sensor follows with a time constant; integrated in small steps."""

    time: float = 5e-3  # [s]
    _shown: float = field(default=0.0, init=False)
    _before: float = field(default=0.0, init=False)

    def start(self, pause: float) -> None:
        """Begin at rest."""
        self._shown = self._before = 0.0

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the delayed force."""
        gain = -math.expm1(-dt / LAG_SUBSTEPS / self.time)
        for i in range(LAG_SUBSTEPS):
            there = self._before + (i + 0.5) / LAG_SUBSTEPS * (shown - self._before)
            self._shown += gain * (there - self._shown)
        self._before = shown
        return self._shown


@dataclass
class SensorDelay(Hidden):
    """The sensor shows what was felt some time ago, from a tape."""

    time: float = 5e-3  # [s]
    _tape: list[tuple[float, float]] = field(default_factory=list, init=False)

    def start(self, pause: float) -> None:
        """Begin at rest."""
        self._tape = [(0.0, 0.0)]

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the force of that time ago."""
        now = self._tape[-1][0] + dt
        self._tape.append((now, shown))
        while len(self._tape) > 2 and self._tape[1][0] <= now - self.time:
            self._tape.pop(0)
        (t0, y0), (t1, y1) = self._tape[:2]
        share = (now - self.time - t0) / (t1 - t0)
        return y0 + min(max(share, 0.0), 1.0) * (y1 - y0)


@dataclass
class CrossTalk(Hidden):
    """The sensor shows a share of the tangential force."""

    share: float = 0.02  # [-]

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the force with what talks across."""
        return shown + self.share * tangential


@dataclass
class Saturation(Hidden):
    """The sensor ends at its full scale."""

    limit: float = 0.8  # [N]

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the force as far as the scale goes."""
        return min(shown, self.limit)


@dataclass
class GuideFriction(Hidden):
    """The guide of the drive drags against its motion; at rest it lets go."""

    force: float = 0.02  # [N]
    speed: float = 1e-4  # [m/s] where 70 % of it is reached
    _at: float = field(default=0.0, init=False)
    _before: float = field(default=0.0, init=False)

    def start(self, pause: float) -> None:
        """Begin at rest, the drive at its zero."""
        self._at = self._before = 0.0

    def moved(self, position: float) -> float:
        """Look where the drive stands."""
        self._at = position
        return position

    def drive(self, mount: float) -> float:
        """Look where the drive stands."""
        self._at = mount
        return mount

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the force with what drags."""
        speed = (self._at - self._before) / dt
        self._before = self._at
        return shown + self.force * speed / math.hypot(speed, self.speed)


@dataclass
class ForceDrift(Hidden):
    """The zero of the sensor runs away at a constant rate, in the pauses too."""

    rate: float = 2e-4  # [N/s]
    _zero: float = field(default=0.0, init=False)
    _started: bool = field(default=False, init=False)

    def start(self, pause: float) -> None:
        """Drift through the pause."""
        self._zero += self.rate * pause if self._started else 0.0
        self._started = True

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return the force on the drifting zero."""
        self._zero += self.rate * dt
        return shown + self._zero
