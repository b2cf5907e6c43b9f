"""Another contact patch under the same forces."""

import math
from dataclasses import dataclass

from vegrip.virtual.hidden.base import Hidden


@dataclass
class RadiusLaw(Hidden):
    """``a^2 = kappa R x``; the plain tip has ``kappa = 2``."""

    kappa: float = 1.4  # [-]

    def radius(self, a: float, x: float, tip_radius: float) -> float:
        """Return the contact radius."""
        return math.sqrt(self.kappa * tip_radius * x) if a > 0.0 else 0.0


@dataclass
class PressureProfile(Hidden):
    """One pressure exponent, whatever the contact has been through."""

    k: float = 5.0  # [-]

    def flattened(self, k: float) -> float:
        """Return the constant exponent."""
        return self.k
