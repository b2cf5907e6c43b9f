"""What lies between the drive and the tip: springs and play."""

from dataclasses import dataclass, field

from vegrip.virtual.hidden.base import Hidden


@dataclass
class SeriesCompliance(Hidden):
    """The mount gives way in proportion to the normal force."""

    compliance: float = 5e-5  # [m/N]


@dataclass
class Backlash(Hidden):
    """Play: the mount stands still until the drive has crossed the gap."""

    width: float = 3e-5  # [m]
    _mount: float = field(default=0.0, init=False)
    _drive: float = field(default=0.0, init=False)

    def moved(self, position: float) -> float:
        """Push the mount with the flank that touches."""
        half = 0.5 * self.width
        self._mount = min(max(self._mount, position - half), position + half)
        self._drive = position
        return self._mount

    def drive(self, mount: float) -> float:
        """Stand at the flank that pushes this way."""
        if mount != self._mount:
            self._drive = mount + (0.5 if mount > self._mount else -0.5) * self.width
            self._mount = mount
        return self._drive
