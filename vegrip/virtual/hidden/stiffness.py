"""Elastic laws other than a power."""

import math
from dataclasses import dataclass

from vegrip.virtual.hidden.base import Hidden


@dataclass
class ExponentialStiffness(Hidden):
    """The force grows by ``(e^s - 1) / s``, s the depth over a length."""

    length: float = 1.5e-3  # [m]

    def elastic(self, force: float, x: float) -> float:
        """Return the stiffened force."""
        s = max(x, 0.0) / self.length
        return force * math.expm1(s) / s if s > 0.0 else force


@dataclass
class HardCore(Hidden):
    """A rigid core under the soft layer, as Garcia and Garcia (Biophysical Journal 114, 2018) have it."""

    thickness: float = 8e-3  # [m] of the layer
    tip_radius: float = 9e-3  # [m]

    def elastic(self, force: float, x: float) -> float:
        """Return the force on the layer: it grows with the radius of the contact over the thickness."""
        X = math.sqrt(self.tip_radius * max(x, 0.0)) / self.thickness
        return force * (1.0 + X * (1.133 + X * (1.497 + X * (1.469 + X * 0.755))))
