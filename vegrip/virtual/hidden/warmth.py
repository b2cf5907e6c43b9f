"""Material that is softer and quicker when it is warm."""

import math
from dataclasses import dataclass, field

from vegrip.types import Floats
from vegrip.virtual.hidden.base import Hidden
from vegrip.virtual.relaxation import Relaxation


@dataclass
class Softening(Hidden):
    """Stiffness falls and rates grow exponentially with the temperature of the episode."""

    softening: float = 0.006  # [1/K]
    quickening: float = 0.05  # [1/K]
    nominal: float = 20.0  # [degrees Celsius]
    _above: float = field(default=0.0, init=False)

    def warmed(self, temperature: float) -> None:
        """Take the temperature of the coming episode."""
        self._above = temperature - self.nominal

    def relaxation(self, g: Relaxation) -> Relaxation:
        """Return g in quicker time."""

        def quicker(t: Floats) -> Floats:
            return g(t * math.exp(self.quickening * self._above))

        return quicker

    def elastic(self, force: float, x: float) -> float:
        """Return the softened force."""
        return force * math.exp(-self.softening * self._above)
