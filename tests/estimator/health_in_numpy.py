"""The verdict of the health over arrays, which the kernel is compared with."""

import math
from typing import NamedTuple

import numpy as np

from vegrip.clock import NS
from vegrip.estimator.health import CALM, FAILS, MENDED, PLAIN, TAKES_OVER
from vegrip.estimator.layout import CHANNELS, PER_CELL, REGIMES
from vegrip.types import Floats

BAND, BIAS, MOVING, SLOW, MOTION, ENOUGH = (0.4, 1.4), 0.25, 1.6, 4.0, 3.0, 200.0
EDGES = np.array(
    [BIAS * (MOVING if "loading" in name else SLOW if name == "late hold" else 1.0) for name in REGIMES]
)
SHAPE = len(CHANNELS), len(REGIMES), len(PER_CELL)


class Verdict(NamedTuple):
    """What the message says of it."""

    nis: float
    consistent: bool
    channel: str
    regime: str


def misfit_of_cells(cells: Floats) -> Floats:
    """Return how far each cell (channels, regimes) is outside, 1 = at the edge, 0 = too little is known."""
    weight, mean, nis = np.moveaxis(cells.reshape(SHAPE), 2, 0)
    bias = abs(mean) / EDGES
    beyond = np.maximum(np.maximum(nis / BAND[1], BAND[0] / np.maximum(nis, 1e-9)), bias)
    beyond[CHANNELS.index("displacement")] /= MOTION
    beyond[:, REGIMES.index("jerk")] = 0.0
    return np.where(weight >= ENOUGH, beyond, 0.0)


class Hysteresis:
    """The verdict over time."""

    def __init__(self) -> None:
        self.failing: tuple[int, int] | None = None
        self._outside: int | None = None
        self._inside: int | None = None

    def update(self, misfit: Floats, stamp: int) -> tuple[int, int] | None:
        """Judge ``misfit`` (channels, regimes); return which cell fails, if any."""
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


def verdict(cells: Floats, stamp: int, hysteresis: Hysteresis) -> Verdict:
    """Return what is said of the section HEALTH of a memory at ``stamp`` [ns]."""
    weight, _, nis = np.moveaxis(cells.reshape(SHAPE), 2, 0)
    told = np.where(np.array(REGIMES) == "jerk", 0.0, weight)
    total = float(np.sum(told))
    failing = hysteresis.update(misfit_of_cells(cells), stamp)
    return Verdict(
        float(np.sum(told * nis)) / total if total > 0.0 else math.nan,
        bool(np.any(weight >= ENOUGH)) and failing is None,
        CHANNELS[failing[0]] if failing is not None else "",
        REGIMES[failing[1]] if failing is not None else "",
    )
