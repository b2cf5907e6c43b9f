"""Relaxation that depends on how deep the indentation is; integrated step by step."""

import math
from dataclasses import dataclass, field

from vegrip.types import Floats
from vegrip.virtual.hidden.base import Hidden
from vegrip.virtual.relaxation import Relaxation


@dataclass
class NonSeparable(Hidden):
    """The share that relaxes grows with the depth at which it was loaded: ``c (1 + growth (x / depth - 1))``.

    A single integral with a kernel that depends on the strain at the time of loading (Pipkin and Rogers).
    """

    growth: float = 0.3  # [-]
    depth: float = 1e-3  # [m]
    amplitude: float = 0.2  # [-] of the material's relaxation
    rate: float = 2.0  # [1/s] of it
    _relaxed: float = field(default=0.0, init=False)

    def start(self, pause: float) -> None:
        """Begin recovered."""
        self._relaxed = 0.0

    def more(self, x: float, elastic: float) -> float:
        """Return what relaxes more [N], as a negative force."""
        return -self.growth * self.amplitude * self._relaxed

    def strained(self, elastic: float, x: float, dt: float) -> None:
        """Let the excess relax."""
        excess = elastic * (max(x, 0.0) / self.depth - 1.0)
        self._relaxed += -math.expm1(-self.rate * dt) * (excess - self._relaxed)


@dataclass
class Drainage(Hidden):
    """All that relaxes does so by flow over the contact radius: the rate falls with the depth."""

    exponent: float = 1.0  # [-] by which it falls
    depth: float = 1e-3  # [m] where it is the nominal one
    amplitude: float = 0.2  # [-]
    rate: float = 2.0  # [1/s]
    shallow: float = 0.05  # least depth over ``depth`` that counts
    _drained: float = field(default=0.0, init=False)
    _speed: float = field(default=0.0, init=False)
    _elastic: float = field(default=0.0, init=False)

    def relaxation(self, g: Relaxation) -> Relaxation:
        """Return no relaxation: it is all in :meth:`more`."""

        def none(t: Floats) -> Floats:
            kept: Floats = 1.0 + 0.0 * t
            return kept

        return none

    def start(self, pause: float) -> None:
        """Begin full."""
        self._drained = self._speed = self._elastic = 0.0

    def more(self, x: float, elastic: float) -> float:
        """Return what has drained, as a negative force [N], carried on to the end of this step."""
        return -self.amplitude * (self._drained + self._speed)

    def strained(self, elastic: float, x: float, dt: float) -> None:
        """Drain for a step, by the mean of the elastic force over it."""
        rate = self.rate * max(x / self.depth, self.shallow) ** -self.exponent
        middle = 0.5 * (elastic + self._elastic)
        self._drained += -math.expm1(-rate * dt) * (middle - self._drained)
        self._speed = -math.expm1(-rate * dt) * (elastic - self._drained)
        self._elastic = elastic
