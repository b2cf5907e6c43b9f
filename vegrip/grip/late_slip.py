"""What the load was when a late slip channel felt what it tells now.

A channel that is late by ``FELT_DELAY`` tells of a slide that may be over: the grip has grown since, or the
load has gone. With u the friction coefficient at which the load would slip, and ``then`` that of a delay ago,
a finger that slid then had mu = ``then``. So

* the onset of slip is evidence of friction by ``then``, not by the present u;
* a slide is over where the present u is below ``LATE_OVER`` of ``then``: the grip need not grow any more.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.felt_slip import *
from vegrip.grip.grasp_memory import BELIEF_MOST, LATE_STEPS, GraspMemory

LATE_OVER = 0.8


def begin_late_slip(g: GraspMemory) -> None:
    """Know of no load yet."""
    for i in range(BELIEF_MOST):
        g.late.age[i] = g.late.ended[i] = 0.0
        for j in range(LATE_STEPS):
            g.late.past[i * LATE_STEPS + j] = math.nan


def is_late(g: GraspMemory) -> bool:
    """Return whether slip is felt with a delay."""
    return g.felt.delay > 0.0


def recall_load(g: GraspMemory, i: int, dt: float, u: float) -> float:
    """Keep the ``u`` of finger ``i``; return that of a delay ago, NaN where it is not known."""
    if not is_late(g):
        return u
    step = g.felt.delay / LATE_STEPS
    first = i * LATE_STEPS
    then = g.late.past[first + LATE_STEPS - 1]
    g.late.age[i] += dt
    for _ in range(LATE_STEPS):
        if g.late.age[i] >= step:
            g.late.age[i] -= step
            for j in range(LATE_STEPS - 1, 0, -1):
                g.late.past[first + j] = g.late.past[first + j - 1]
            g.late.past[first] = u
    g.late.age[i] = min(g.late.age[i], step)
    g.late.ended[i] = 1.0 if u < LATE_OVER * then else 0.0
    return then


def present_slip(g: GraspMemory, i: int, slip: float) -> float:
    """Return the ``slip`` flag or speed of finger ``i`` as it is now: none where the slide is over."""
    return 0.0 if slip > 0.0 and g.late.ended[i] > 0.0 else slip
