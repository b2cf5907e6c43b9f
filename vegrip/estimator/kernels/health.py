"""How far the innovations are from what the model leaves room for, in one look at all cells.

A mean NIS near 1 alone proves little: a filter that was 21 um wrong in the indentation still had 0.98. So the
mean innovation is watched as well, in every regime of its own: air, loading, hold, unloading, each shallow or
deep, slow or fast, early or late, and sliding. What follows a jerk shows the motion and is not judged. Where
no displacement is measured the force is followed, whatever it is, and agrees too well.
"""

import math

from vegrip.estimator.kernels.generated import *

LEAST_NIS = 0.4
MOST_NIS = 1.4
"""Between them the mean NIS of a cell counts as consistent."""

BIAS_EDGE = 0.25
"""Mean normalised innovation of a cell beyond which it does not, whatever its NIS.

With nothing missing it stayed below 0.08 at rest and in the air, and reached 0.27 in motion.
"""

IN_MOTION = 1.6
"""So much wider where the tip loads or unloads: how a motion begins and ends shows there as well."""

WHILE_LATE = 4.0
"""So much wider late in a hold: relaxation slower than the model's shifts the mean there by up to a noise,
and the stiffness follows it; a hand that holds should not report that all the time."""

OF_DISPLACEMENT = 3.0
"""So much wider for the displacement: its innovations show how suddenly motion starts, not the contact."""

ENOUGH = 200.0
"""Samples in the (fading) memory of a cell before it is judged."""

AT_REST = (REGIME_AIR, REGIME_HOLD, REGIME_DEEP_HOLD, REGIME_SLIDING)
"""Regimes in which neither holds."""


def look_at_cells(m: Floats, before: float, out: Floats) -> None:
    """Write mean NIS, worst cell, its misfit and that of cell ``before`` (-1: none), cells judged, refusals.

    A cell is ``REGIMES * channel + regime``, a misfit 1 at the edge.
    """
    weights, weighted, judged, rejected = 0.0, 0.0, 0.0, 0.0
    worst, top, known = 0.0, 0.0, 0.0
    for channel in range(CHANNELS):
        rejected += m.channel[CHANNEL_SIZE * channel + CH_REJECTED]
        for i in range(REGIMES):
            regime = float(i)
            cell, at = float(REGIMES * channel + i), HEALTH0 + CELL_SIZE * (REGIMES * channel + i)
            if regime != REGIME_JERK:
                weights += m[at + CELL_WEIGHT]
                weighted += m[at + CELL_WEIGHT] * m[at + CELL_NIS]
            if m[at + CELL_WEIGHT] >= ENOUGH:
                judged += 1.0
            misfit = misfit_of_cell(m, channel, regime, at)
            if cell == before:
                known = misfit
            if misfit > top:
                worst, top = cell, misfit
    out[0] = weighted / weights if weights > 0.0 else math.nan
    out[1], out[2], out[3], out[4], out[5] = worst, top, known, judged, rejected


def misfit_of_cell(m: Floats, channel: int, regime: float, at: int) -> float:
    """How far the cell at ``at`` is outside, 1 = at the edge, 0 = too little is known, or not judged."""
    if regime == REGIME_JERK or not m[at + CELL_WEIGHT] >= ENOUGH:
        return 0.0
    nis, bias = float(m[at + CELL_NIS]), float(abs(m[at + CELL_MEAN])) / edge_of_regime(regime)
    if not math.isfinite(nis + bias):
        return math.inf
    misfit = max(nis / MOST_NIS, bias)
    if not (channel == CHANNEL_FORCE and m.mode.blind > 0.0):
        misfit = max(misfit, LEAST_NIS / max(nis, 1e-9))
    return misfit / OF_DISPLACEMENT if channel == CHANNEL_DISPLACEMENT else misfit


def edge_of_regime(regime: float) -> float:
    """Mean normalised innovation up to which a regime counts as consistent."""
    width = IN_MOTION
    if regime == REGIME_LATE_HOLD:
        width = WHILE_LATE
    for at_rest in AT_REST:
        if regime == at_rest:
            width = 1.0
    return BIAS_EDGE * width
