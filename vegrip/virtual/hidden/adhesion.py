"""Adhesion with hysteresis: no pull on approach, a neck that holds until it is stretched too far."""

from dataclasses import dataclass, field

from vegrip.virtual.hidden.base import Hidden


@dataclass
class Adhesion(Hidden):
    """A constant pull in contact; in the gap it falls evenly to zero over the stretch of the neck."""

    force: float = 0.03  # [N]
    stretch: float = 1e-4  # [m] of the neck when it tears
    _touching: bool = field(default=False, init=False)

    def start(self, pause: float) -> None:
        """Begin with parted surfaces."""
        self._touching = False

    def pull(self, x: float) -> float:
        """Return the pull [N]."""
        if x > 0.0:
            return self.force
        if not self._touching:
            return 0.0
        return self.force * max(1.0 + x / self.stretch, 0.0)

    def remember(self, x: float, force: float, dt: float) -> None:
        """Touch, or tear."""
        self._touching = x > (-self.stretch if self._touching else 0.0)
