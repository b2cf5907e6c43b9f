"""What an indentation leaves behind: a dent, or softened rubber."""

import math
from dataclasses import dataclass, field

from vegrip.virtual.hidden.base import Hidden


@dataclass
class PermanentSet(Hidden):
    """The surface keeps a share of its deepest indentation beyond a threshold, and never recovers."""

    share: float = 0.03  # [-]
    threshold: float = 3e-4  # [m]
    _deepest: float = field(default=0.0, init=False)

    def indentation(self, x: float) -> float:
        """Return the indentation from the dented surface."""
        return x - self.share * max(self._deepest - self.threshold, 0.0)

    def remember(self, x: float, force: float, dt: float) -> None:
        """Keep the deepest indentation."""
        self._deepest = max(self._deepest, x)


@dataclass
class Mullins(Hidden):
    """Below the deepest indentation so far the material is softer; it does not heal."""

    loss: float = 0.12  # [-] of the force far below it
    width: float = 4e-4  # [m]
    _deepest: float = field(default=0.0, init=False)

    def elastic(self, force: float, x: float) -> float:
        """Return the elastic force on the virgin or on the softened curve."""
        return force * (1.0 - self.loss * math.tanh(max(self._deepest - x, 0.0) / self.width))

    def remember(self, x: float, force: float, dt: float) -> None:
        """Keep the deepest indentation."""
        self._deepest = max(self._deepest, x)
