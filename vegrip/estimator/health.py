"""Whether the model still explains the measurements: the verdict over time.

How far the innovations are outside, by channel and regime, is worked out where they lie
(:mod:`vegrip.estimator.kernels.health`).
"""

from typing import NamedTuple

from vegrip.clock import NS

FAILS = 0.5  # [s] for which a cell has to be outside before the model is said to fail,
PLAIN = 2.0  # or so far outside
CALM = 0.8  # of the way to the edge, within which all cells have to be
MENDED = 10.0  # [s] for so long, before it is said to explain again
TAKES_OVER = 1.25  # by how much another cell has to be worse than the one that was reported

NO_CELL = -1


class Look(NamedTuple):
    """What :func:`~vegrip.estimator.kernels.health.look_at_cells` writes, in its order.

    A cell is ``len(REGIMES) * channel + regime``, a misfit 1 at the edge.
    """

    nis: float
    """Mean NIS of all that is judged; NaN where nothing was measured."""
    worst: float
    """The cell that fails most."""
    misfit: float
    """Of the worst cell."""
    reported_misfit: float
    """Of the cell that was said to fail."""
    judged: float
    """Cells with enough samples."""
    rejected: float
    """Measurements refused by the outlier gate."""


class HealthHysteresis:
    """The verdict over time, with hysteresis: it neither comes with a single look nor goes with one."""

    def __init__(self) -> None:
        self.failing = NO_CELL
        """The cell that fails most."""
        self._outside: int | None = None  # [ns] since when some cell is outside
        self._inside: int | None = None  # [ns] since when all are well inside

    def follow_clock(self) -> None:
        """Count anew what has lasted: the stamps come from another clock now."""
        self._outside = self._inside = None

    def update(self, worst: int, misfit: float, reported_misfit: float, stamp: int) -> int:
        """Judge the ``misfit`` of the ``worst`` cell at ``stamp`` [ns]; return which cell fails, or NO_CELL.

        ``reported_misfit`` is that of :attr:`failing`.
        """
        self._outside = None if misfit <= 1.0 else stamp if self._outside is None else self._outside
        self._inside = None if misfit >= CALM else stamp if self._inside is None else self._inside
        lasting = self._outside is not None and stamp - self._outside >= FAILS * NS
        if lasting or misfit > PLAIN:
            if self.failing == NO_CELL or misfit > TAKES_OVER * reported_misfit:
                self.failing = worst
        elif self._inside is not None and stamp - self._inside >= MENDED * NS:
            self.failing = NO_CELL
        return self.failing
