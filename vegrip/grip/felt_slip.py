"""Whether a finger slides by what it feels, and whether its flag and its slip speed can be believed.

A finger slides where its slip flag says so, or where its slip speed is above ``sliding``: part of a patch
slides before all of it does, above all under a twist. Both are held against the load. With u the friction
coefficient at which the present load would slip, a contact that slides has u = mu, and it stops when the grip
has grown and u has fallen. What a channel says with no more than ``FELT_BURST`` of silence between is one
burst. Below ``FELT_FALLEN`` of the largest u of a burst the slide is over, whatever the channel says: the
grip does not grow any more. And

* a channel that says slip there for ``FELT_FALLEN_TIME``, after the delay that it is told to have,
  contradicts the load; so does a flag for ``FELT_EMPTY_TIME`` without any slip speed, where that is
  measured; single samples count for ``FELT_LEAST_TIME`` each, and are forgotten within ``FELT_FORGET``;
* a flag that is silent for ``FELT_SILENT_TIME`` while the slip speed shows a slide of a patch that is not
  twisted does not tell, or tells too late;
* a channel is deaf that does not tell a slide which the load shows (:mod:`~vegrip.grip.slip_trust`).

Such a channel is not believed for ``FELT_DISTRUST`` after it has last said slip: it counts as not sensed.

Plain scalar code over the flat sequence of :mod:`~vegrip.grip.friction_probe`, behind its sections and those
of :mod:`~vegrip.grip.load_lead`; the same text is compiled.
"""

import math

from vegrip.grip.load_lead import *
from vegrip.types import Numbers

FELT_SLIDING = LEAD_SIZE  # [m/s] slip speed from which a finger slides; 0 = the flag alone tells
FELT_DELAY = LEAD_SIZE + 1  # [s] by which what is felt is late
FELT_FLAG = LEAD_SIZE + 2  # FELT_WIDTH numbers for the flag of finger i
FELT_WIDTH = 8
FELT_SPEED = FELT_FLAG + FELT_WIDTH * BELIEF_MOST  # the same for its slip speed
FELT_SIZE = FELT_SPEED + FELT_WIDTH * BELIEF_MOST

FELT_QUIET = 0  # [s] since the channel last said slip
FELT_BEGAN = 1  # largest u of the burst, 0 = was not known
FELT_LOW = 2  # [s] for which it has said slip of late with u far below that
FELT_OVER = 3  # [s] for which u has been far below that
FELT_AGAINST = 4  # [s] for which the other channel has said otherwise
FELT_OFF = 5  # [s] for which the channel will not be believed
FELT_WHY = 6  # one of the reasons below
FELT_LIVE = 7  # [s] for which it has been sensed and silent, up to FELT_SILENCE; 0 where it is not sensed

FELT_BY_LOAD, FELT_BY_OTHER, FELT_SILENT, FELT_DEAF = 1.0, 2.0, 3.0, 4.0

FELT_FALLEN = 0.6
FELT_FALLEN_TIME = 0.03  # [s]
FELT_LEAST_TIME = 0.01  # [s]
FELT_BURST = 1.0  # [s]
FELT_FORGET = 2.0  # [s]
FELT_SILENCE = 0.5  # [s] of silence that must come before what a flag tells teaches friction
FELT_EMPTY_TIME = 0.05  # [s]
FELT_SILENT_TIME = 0.15  # [s]
FELT_DISTRUST = 30.0  # [s]
FELT_CREEP = 1e-4  # [m/s] below which a slip speed shows none
FELT_TWIST = 0.5  # share of a twist in the load from which a patch may slide in part


def begin_felt_slip(q: Numbers, sliding: float, delay: float) -> None:
    """Set from which slip speed [m/s] a finger slides, and by how much that is late [s]; all is believed."""
    q[FELT_SLIDING], q[FELT_DELAY] = sliding, delay
    for j in range(2 * FELT_WIDTH * BELIEF_MOST):
        q[FELT_FLAG + j] = 0.0


def believed_flag(q: Numbers, i: int, slip: float) -> float:
    """Return the slip flag of finger ``i``: NaN while it is not believed, 0 where the slide is over.

    A flag is 0 or 1; what lies between is none.
    """
    return believed(q, FELT_FLAG + FELT_WIDTH * i, slip) if slip <= 0.0 or slip >= 1.0 else math.nan


def believed_speed(q: Numbers, i: int, speed: float) -> float:
    """Return the slip speed [m/s] of finger ``i``, as :func:`believed_flag`."""
    return believed(q, FELT_SPEED + FELT_WIDTH * i, speed)


def believed(q: Numbers, at: int, value: float) -> float:
    """Return what the channel at ``at`` says, as far as it is believed."""
    if q[at + FELT_OFF] > 0.0:
        return math.nan
    return 0.0 if value > 0.0 and q[at + FELT_OVER] > 0.0 else value


def may_teach(q: Numbers, i: int) -> bool:
    """Return whether slip that the flag of finger ``i`` tells is evidence.

    The flag has been silent before, and the onset of this slip has not taught: one slip is one sample of what
    friction is, and counted twice it makes the belief too sure.
    """
    return q[FELT_FLAG + FELT_WIDTH * i + FELT_LIVE] >= FELT_SILENCE and not has_taught(q, i)


def shows_sliding(q: Numbers, speed: float) -> bool:
    """Return whether a slip speed [m/s] is one of a finger that slides."""
    return q[FELT_SLIDING] > 0.0 and speed >= q[FELT_SLIDING]


def twist_share(tangential: float, load: float) -> float:
    """Return the share of the twist [-] in a ``load`` [N] of which ``tangential`` [N] is none."""
    return 1.0 - tangential / load if load > 0.0 else 0.0


def judge_felt_slip(q: Numbers, i: int, dt: float, slip: float, speed: float, u: float, twist: float) -> None:
    """Hold what finger ``i`` feels against its load.

    Args:
        q: the state.
        i: the finger.
        dt: [s] since the last sample.
        slip: flag as it is sensed.
        speed: slip speed as it is sensed [m/s].
        u: friction coefficient at which the present load would slip; NaN = not known.
        twist: share of the twist in the load [-].

    """
    flagged, slides = slip >= 0.5, shows_sliding(q, speed)
    flag, fast = FELT_FLAG + FELT_WIDTH * i, FELT_SPEED + FELT_WIDTH * i
    lasts = max(dt, FELT_LEAST_TIME) if q[flag + FELT_QUIET] > 0.0 else dt
    follow_claim(q, flag, dt, flagged, u)
    follow_claim(q, fast, dt, slides, u)
    if math.isnan(slip):
        q[flag + FELT_LIVE] = 0.0
    elif not flagged:
        q[flag + FELT_LIVE] = min(q[flag + FELT_LIVE] + dt, FELT_SILENCE)
    empty = flagged and speed < FELT_CREEP
    silent = slides and slip < 0.5 and twist < FELT_TWIST and q[fast + FELT_OFF] <= 0.0
    q[flag + FELT_AGAINST] *= math.exp(-dt / FELT_FORGET)
    q[flag + FELT_AGAINST] += lasts if empty else 0.0
    q[fast + FELT_AGAINST] = q[fast + FELT_AGAINST] + dt if silent else 0.0
    if empty and q[flag + FELT_AGAINST] > FELT_EMPTY_TIME + q[FELT_DELAY]:
        distrust(q, flag, FELT_BY_OTHER, FELT_DISTRUST)
    if q[fast + FELT_AGAINST] > FELT_SILENT_TIME + q[FELT_DELAY]:
        distrust(q, flag, FELT_SILENT, FELT_DISTRUST)


def follow_claim(q: Numbers, at: int, dt: float, says: bool, u: float) -> None:
    """Follow the channel at ``at``, which ``says`` that the finger slides or not."""
    known = 0.0 < u < math.inf
    q[at + FELT_LOW] *= math.exp(-dt / FELT_FORGET)
    q[at + FELT_OVER] = q[at + FELT_OVER] + dt if known and u < FELT_FALLEN * q[at + FELT_BEGAN] else 0.0
    if not says:
        q[at + FELT_QUIET] += dt
        if q[at + FELT_QUIET] > FELT_BURST:
            q[at + FELT_BEGAN] = 0.0
        q[at + FELT_OFF] = max(q[at + FELT_OFF] - dt, 0.0)
        return
    if known:
        q[at + FELT_BEGAN] = max(q[at + FELT_BEGAN], u)
    if q[at + FELT_OVER] > q[FELT_DELAY]:
        q[at + FELT_LOW] += max(dt, FELT_LEAST_TIME) if q[at + FELT_QUIET] > 0.0 else dt
        if q[at + FELT_LOW] > FELT_FALLEN_TIME:
            distrust(q, at, FELT_BY_LOAD, FELT_DISTRUST)
    q[at + FELT_QUIET] = 0.0


def distrust(q: Numbers, at: int, why: float, lasts: float) -> None:
    """Do not believe the channel at ``at`` for so long [s] after it has last said slip."""
    q[at + FELT_OFF], q[at + FELT_WHY] = max(lasts, q[at + FELT_OFF]), why
