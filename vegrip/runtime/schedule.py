"""When the next tick is due: an absolute grid that late ticks never shift."""

from vegrip.clock import NS


class Schedule:
    """Ticks at ``start + i * period``.

    A tick served late is followed by the next one of the same grid; ticks whose whole period has passed are
    skipped and counted, never bunched up.
    """

    def __init__(self, period: float) -> None:
        self.period = round(period * NS)  # [ns]
        self.due = 0  # [ns]
        self.skipped = 0

    def start(self, now: int) -> None:
        """Lay the grid: the first tick is due at once."""
        self.due = now

    def take(self, now: int) -> int:
        """Serve the tick that is due and return its lateness [ns]."""
        late = now - self.due
        skipped = late // self.period
        self.skipped += skipped
        self.due += (skipped + 1) * self.period
        return late
