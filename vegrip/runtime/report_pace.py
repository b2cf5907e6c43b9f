"""Fewer reports on a machine that cannot keep up; commands are never left out."""

from typing import Final

from vegrip.clock import NS

WEIGHT: Final = 1 / 256
"""Of one command in the share of late ones: it looks back over some hundred commands."""

SLOW_SHARE, WELL_SHARE = 0.1, 0.01
"""Shares of late commands from which on reports are left out, and below which they all come again."""

SLOW_PERIOD_NS: Final = NS // 5
"""[ns] between the reports of a finger on a machine that cannot keep up."""

MOST_FINGERS: Final = 256


class ReportPace:
    """Watches how late commands are, and says which reports may follow them.

    Args:
        deadline: [ns] of a command; one that takes more than half of it is late here.

    """

    def __init__(self, deadline: int) -> None:
        self.lowered = 0  # how often the rate of reports was lowered
        self._late = deadline // 2
        self._share = 0.0
        self._is_slow = False
        self._reported: dict[str, int] = {}  # [ns] by finger, while reports are left out

    def answered(self, latency: int) -> None:
        """Take note of a command that left ``latency`` [ns] after its state had come."""
        self._share += WEIGHT * ((latency > self._late) - self._share)
        if self._is_slow and self._share < WELL_SHARE:
            self._is_slow = False
            self._reported.clear()
        elif not self._is_slow and self._share > SLOW_SHARE:
            self._is_slow = True
            self.lowered += 1

    def allows(self, finger: str, now: int) -> bool:
        """Whether what follows a command of ``finger`` at ``now`` [ns] is to be worked out."""
        if not self._is_slow:
            return True
        last = self._reported.get(finger)
        if last is not None and 0 <= now - last < SLOW_PERIOD_NS:
            return False
        if last is None and len(self._reported) >= MOST_FINGERS:
            return False
        self._reported[finger] = now
        return True
