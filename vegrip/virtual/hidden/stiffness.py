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
    """A rigid core under the soft layer: the force rises without bound as the layer is used up."""

    thickness: float = 5e-3  # [m] of the layer

    def elastic(self, force: float, x: float) -> float:
        """Return the force on what is left of the layer."""
        return force / (1.0 - min(max(x, 0.0) / self.thickness, 0.99)) ** 2
