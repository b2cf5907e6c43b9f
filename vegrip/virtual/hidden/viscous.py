"""Force that depends on the speed of the indentation."""

import math
from dataclasses import dataclass, field

from vegrip.virtual.hidden.base import Hidden


@dataclass
class FastDamping(Hidden):
    """A dashpot beside the spring: it pushes with the rate of the elastic force.

    The rate is that at the end of a step, to second order: the mean rate over the step is half a step old,
    which is no small part of the time constant.
    """

    time: float = 4e-3  # [s]
    _elastic: float = field(default=0.0, init=False)
    _before: float = field(default=0.0, init=False)
    _dt: float = field(default=1.0, init=False)

    def start(self, pause: float) -> None:
        """Begin at rest."""
        self._elastic = self._before = 0.0

    def more(self, x: float, elastic: float) -> float:
        """Return the viscous force [N]."""
        return self.time * (1.5 * elastic - 2.0 * self._elastic + 0.5 * self._before) / self._dt

    def strained(self, elastic: float, x: float, dt: float) -> None:
        """Keep the elastic force."""
        self._before, self._elastic, self._dt = self._elastic, elastic, dt


@dataclass
class RateStiffening(Hidden):
    """While the indentation grows the elastic force is higher, by the logarithm of the speed."""

    growth: float = 0.03  # [-] per e-fold
    slow: float = 2e-4  # [m/s] where the growth begins
    _x: float = field(default=0.0, init=False)
    _dt: float = field(default=1.0, init=False)

    def start(self, pause: float) -> None:
        """Begin at rest."""
        self._x = 0.0

    def more(self, x: float, elastic: float) -> float:
        """Return what is added [N]."""
        return self.growth * elastic * math.log1p(max(x - self._x, 0.0) / self._dt / self.slow)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        """Keep the indentation."""
        self._x, self._dt = x, dt
