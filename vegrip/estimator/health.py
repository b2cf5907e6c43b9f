"""Whether the model still explains the measurements: normalised innovations by channel and regime.

A mean NIS near 1 alone proves little: a filter that was 21 um wrong in the indentation still had 0.98. So the
mean innovation is watched as well, in every regime of its own: air, loading, hold, unloading, each shallow or
deep, slow or fast, early or late, and sliding. What follows a jerk tells of the motion and is not judged.
"""

import math

import numpy as np

from vegrip.clock import NS
from vegrip.estimator.layout import CHANNELS, PER_CELL, PER_CHANNEL, REGIMES
from vegrip.messages import Condition, FingertipState, ModelHealth
from vegrip.types import Floats

BAND = (0.4, 1.4)
"""Mean NIS in which the filter counts as consistent, once enough samples are in."""

BIAS = 0.25
"""Mean normalised innovation of a regime beyond which it does not, whatever its NIS.

With nothing missing it stayed below 0.08 at rest and in the air, and reached 0.27 in motion.
"""

MOVING = 1.6
"""So much wider where the tip loads or unloads: how a motion begins and ends shows there as well."""

SLOW = 4.0
"""So much wider late in a hold: relaxation slower than the model's shifts the mean there by up to a noise,
and the stiffness follows it; a hand that holds should not be told of that all the time."""

EDGES = np.array(
    [BIAS * (MOVING if "loading" in name else SLOW if name == "late hold" else 1.0) for name in REGIMES]
)

MOTION = 3.0
"""So much wider for the displacement: its innovations tell how suddenly motion starts, not the contact."""

JERK = "jerk"
"""Regime of what follows a jerk of the motion: neither judged nor told."""

ENOUGH = 200.0
"""Samples in the (fading) memory of a cell before it is judged."""

FAILS = 0.5  # [s] for which a cell has to be outside before the model is said to fail,
PLAIN = 2.0  # or so far outside
CALM = 0.8  # of the way to the edge, within which all cells have to be
MENDED = 10.0  # [s] for so long, before it is said to explain again
TAKES_OVER = 1.25  # by how much another cell has to be worse than the one that was told


class HealthHysteresis:
    """The verdict over time, with hysteresis: it neither comes with a single look nor goes with one."""

    def __init__(self) -> None:
        self.failing: tuple[int, int] | None = None  # channel and regime that fail most
        self._outside: int | None = None  # [ns] since when some cell is outside
        self._inside: int | None = None  # [ns] since when all are well inside

    def follow_clock(self) -> None:
        """Count anew what has lasted: the stamps come from another clock now."""
        self._outside = self._inside = None

    def update(self, misfit: Floats, stamp: int) -> tuple[int, int] | None:
        """Judge ``misfit`` (channels, regimes), 1 = at the edge; return which cell fails, if any."""
        worst = np.unravel_index(int(np.argmax(misfit)), misfit.shape)
        top = float(misfit[worst])
        self._outside = None if top <= 1.0 else stamp if self._outside is None else self._outside
        self._inside = None if top >= CALM else stamp if self._inside is None else self._inside
        lasting = self._outside is not None and stamp - self._outside >= FAILS * NS
        if lasting or top > PLAIN:
            if self.failing is None or top > TAKES_OVER * float(misfit[self.failing]):
                self.failing = (int(worst[0]), int(worst[1]))
        elif self._inside is not None and stamp - self._inside >= MENDED * NS:
            self.failing = None
        return self.failing


def misfit_of_cells(cells: Floats) -> Floats:
    """Return how far each cell (channels, regimes) is outside, 1 = at the edge, 0 = too little is known."""
    weight, mean, nis = np.moveaxis(cells.reshape(len(CHANNELS), len(REGIMES), len(PER_CELL)), 2, 0)
    bias = abs(mean) / EDGES
    beyond = np.maximum(np.maximum(nis / BAND[1], BAND[0] / np.maximum(nis, 1e-9)), bias)
    beyond[CHANNELS.index("displacement")] /= MOTION
    beyond[:, REGIMES.index(JERK)] = 0.0
    return np.where(weight >= ENOUGH, beyond, 0.0)


def health_of(
    state: FingertipState,
    seq: int,
    condition: Condition,
    cells: Floats,
    channels: Floats,
    hysteresis: HealthHysteresis,
) -> ModelHealth:
    """Return the health message from the sections HEALTH and CHANNEL of an estimator's memory."""
    weight, _, nis = np.moveaxis(cells.reshape(len(CHANNELS), len(REGIMES), len(PER_CELL)), 2, 0)
    told = np.where(np.array(REGIMES) == JERK, 0.0, weight)
    total = float(np.sum(told))
    failing = hysteresis.update(misfit_of_cells(cells), state.stamp)
    return ModelHealth(
        state.stamp,
        state.finger,
        seq,
        condition=condition,
        nis=float(np.sum(told * nis)) / total if total > 0.0 else math.nan,
        consistent=bool(np.any(weight >= ENOUGH)) and failing is None,
        channel=CHANNELS[failing[0]] if failing is not None else "",
        regime=REGIMES[failing[1]] if failing is not None else "",
        rejected=int(channels.reshape(len(CHANNELS), -1)[:, PER_CHANNEL.index("REJECTED")].sum()),
    )
