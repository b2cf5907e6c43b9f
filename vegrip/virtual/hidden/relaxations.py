"""Material that relaxes on further time scales."""

from dataclasses import dataclass

import numpy as np

from vegrip.types import Floats
from vegrip.virtual.hidden.base import Hidden
from vegrip.virtual.relaxation import Relaxation


@dataclass
class SecondRelaxation(Hidden):
    """One more exponential."""

    amplitude: float = 0.1  # [-]
    rate: float = 0.2  # [1/s]

    def relaxation(self, g: Relaxation) -> Relaxation:
        """Return g, less what relaxes more."""

        def more(t: Floats) -> Floats:
            left: Floats = g(t) + self.amplitude * np.expm1(-self.rate * t)
            return left

        return more


@dataclass
class PowerLawRelaxation(Hidden):
    """A share that relaxes as ``(1 + t / time)^-exponent``."""

    amplitude: float = 0.3  # [-]
    time: float = 0.01  # [s]
    exponent: float = 0.1  # [-]

    def relaxation(self, g: Relaxation) -> Relaxation:
        """Return g, less what relaxes more."""

        def more(t: Floats) -> Floats:
            left: Floats = g(t) - self.amplitude * (1.0 - (1.0 + t / self.time) ** -self.exponent)
            return left

        return more
