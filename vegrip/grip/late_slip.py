"""What the load was when a late slip channel felt what it tells now.

A channel that is late by ``FELT_DELAY`` tells of a slide that may be over: the grip has grown since, or the
load has gone. With u the friction coefficient at which the load would slip, and ``then`` that of a delay ago,
a finger that slid then had mu = ``then``. So

* the onset of slip is evidence of friction by ``then``, not by the present u;
* a slide is over where the present u is below ``LATE_OVER`` of ``then``: the grip need not grow any more.

Plain scalar code over the flat sequence of :mod:`~vegrip.grip.friction_probe`, behind the section of
:mod:`~vegrip.grip.felt_slip`; the same text is compiled.
"""

import math

from vegrip.grip.felt_slip import *
from vegrip.types import Numbers

LATE_STEPS = 8  # in which a delay is kept
LATE_AGE = FELT_SIZE  # [s] since the last step of finger i
LATE_ENDED = LATE_AGE + BELIEF_MOST  # 1 where the slide of finger i that is felt now is over
LATE_PAST = LATE_ENDED + BELIEF_MOST  # u of finger i, the newest first, from LATE_STEPS i on
LATE_SIZE = LATE_PAST + LATE_STEPS * BELIEF_MOST

LATE_OVER = 0.8


def begin_late_slip(q: Numbers) -> None:
    """Know of no load yet."""
    for i in range(BELIEF_MOST):
        q[LATE_AGE + i] = q[LATE_ENDED + i] = 0.0
        for j in range(LATE_STEPS):
            q[LATE_PAST + i * LATE_STEPS + j] = math.nan


def is_late(q: Numbers) -> bool:
    """Return whether slip is felt with a delay."""
    return q[FELT_DELAY] > 0.0


def recall_load(q: Numbers, i: int, dt: float, u: float) -> float:
    """Keep the ``u`` of finger ``i``; return that of a delay ago, NaN where it is not known."""
    if not is_late(q):
        return u
    step = q[FELT_DELAY] / LATE_STEPS
    first = LATE_PAST + i * LATE_STEPS
    then = q[first + LATE_STEPS - 1]
    q[LATE_AGE + i] += dt
    for _ in range(LATE_STEPS):
        if q[LATE_AGE + i] >= step:
            q[LATE_AGE + i] -= step
            for j in range(LATE_STEPS - 1, 0, -1):
                q[first + j] = q[first + j - 1]
            q[first] = u
    q[LATE_AGE + i] = min(q[LATE_AGE + i], step)
    q[LATE_ENDED + i] = 1.0 if u < LATE_OVER * then else 0.0
    return then


def present_slip(q: Numbers, i: int, slip: float) -> float:
    """Return the ``slip`` flag or speed of finger ``i`` as it is now: none where the slide is over."""
    return 0.0 if slip > 0.0 and q[LATE_ENDED + i] > 0.0 else slip
