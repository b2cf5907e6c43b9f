"""Whether the model still explains the measurements: normalised innovations by channel and regime.

A mean NIS near 1 alone proves little: a filter that was 21 um wrong in the indentation still had 0.98. So the
mean innovation is watched as well, in every regime of its own (air, loading, hold, unloading).
"""

import math

import numpy as np
from numpy.typing import NDArray

from vegrip.estimator.layout import CHANNELS, REGIMES
from vegrip.messages import Condition, FingertipState, ModelHealth

BAND = (0.5, 1.7)
"""Mean NIS in which the filter counts as consistent, once enough samples are in."""

BIAS = 0.6
"""Mean normalised innovation of a regime beyond which it does not, whatever its NIS."""

ENOUGH = 50.0
"""Samples in the (fading) memory of a cell before it is judged."""


def health_of(
    state: FingertipState,
    seq: int,
    condition: Condition,
    cells: NDArray[np.float64],
    channels: NDArray[np.float64],
) -> ModelHealth:
    """Return the health message from the sections HEALTH and CHANNEL of an estimator's memory."""
    weight, mean, nis = np.moveaxis(cells.reshape(len(CHANNELS), len(REGIMES), 3), 2, 0)
    used = weight > 0.0
    overall = float(np.sum(weight * nis) / np.sum(weight)) if used.any() else math.nan
    judged = weight >= ENOUGH
    # how far a cell is outside, 1 = at the edge
    wrong = np.where(
        judged, np.maximum(np.maximum(nis / BAND[1], BAND[0] / np.maximum(nis, 1e-9)), abs(mean) / BIAS), 0.0
    )
    channel, regime = np.unravel_index(int(np.argmax(wrong)), wrong.shape)
    failing = bool(wrong[channel, regime] > 1.0)
    return ModelHealth(
        state.stamp,
        state.finger,
        seq,
        condition=condition,
        nis=overall,
        consistent=bool(judged.any()) and not failing,
        channel=CHANNELS[channel] if failing else "",
        regime=REGIMES[regime] if failing else "",
        rejected=int(channels.reshape(len(CHANNELS), 4)[:, 1].sum()),
    )
