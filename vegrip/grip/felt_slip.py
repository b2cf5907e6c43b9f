"""Whether a finger slides by what it feels, and whether its flag and its slip speed can be believed.

A finger slides where its slip flag says so, or where its slip speed is above ``sliding``: part of a patch
slides before all of it does, above all under a twist. Both are held against the load. With u the friction
coefficient at which the present load would slip, a contact that slides has u = mu, and it stops when the grip
has grown and u has fallen. So

* a channel that says slip for ``FELT_FALLEN_TIME`` while u is below ``FELT_FALLEN`` of what it was when it
  began contradicts the load;
* so does a flag for ``FELT_EMPTY_TIME`` without any slip speed, where that is measured;
* a flag that is silent for ``FELT_SILENT_TIME`` while the slip speed shows a slide of a patch that is not
  twisted does not tell, or tells too late.

Such a channel is not believed for ``FELT_DISTRUST`` after it has last said slip: it counts as not sensed.

Plain scalar code over the flat sequence of :mod:`~vegrip.grip.friction_probe`, behind its sections and those
of :mod:`~vegrip.grip.load_lead`; the same text is compiled.
"""

import math

from vegrip.grip.friction_belief import BELIEF_MOST
from vegrip.grip.load_lead import LEAD_SIZE
from vegrip.types import Numbers

FELT_SLIDING = LEAD_SIZE  # [m/s] slip speed from which a finger slides; 0 = the flag alone tells
FELT_DELAY = LEAD_SIZE + 1  # [s] by which what is felt is late
FELT_FLAG = LEAD_SIZE + 2  # 6 numbers for the flag of finger i from 6 i on
FELT_SPEED = FELT_FLAG + 6 * BELIEF_MOST  # the same for its slip speed
FELT_SIZE = FELT_SPEED + 6 * BELIEF_MOST

FELT_LASTS = 0  # [s] for which the channel has said slip
FELT_BEGAN = 1  # u when it began, 0 = was not known
FELT_LOW = 2  # [s] for which u has been far below that
FELT_AGAINST = 3  # [s] for which the other channel has said otherwise
FELT_OFF = 4  # [s] for which the channel will not be believed
FELT_WHY = 5  # one of the reasons below

FELT_BY_LOAD, FELT_BY_OTHER, FELT_SILENT = 1.0, 2.0, 3.0

FELT_FALLEN = 0.6
FELT_FALLEN_TIME = 0.03  # [s]
FELT_EMPTY_TIME = 0.05  # [s]
FELT_SILENT_TIME = 0.15  # [s]
FELT_DISTRUST = 30.0  # [s]
FELT_CREEP = 1e-4  # [m/s] below which a slip speed shows none
FELT_TWIST = 0.5  # share of a twist in the load from which a patch may slide in part


def begin_felt_slip(q: Numbers, sliding: float, delay: float) -> None:
    """Set from which slip speed [m/s] a finger slides, and by how much that is late [s]; all is believed."""
    q[FELT_SLIDING], q[FELT_DELAY] = sliding, delay
    for j in range(12 * BELIEF_MOST):
        q[FELT_FLAG + j] = 0.0


def believed_flag(q: Numbers, i: int, slip: float) -> float:
    """Return the slip flag of finger ``i``, NaN while it is not believed."""
    return math.nan if q[FELT_FLAG + 6 * i + FELT_OFF] > 0.0 else slip


def believed_speed(q: Numbers, i: int, speed: float) -> float:
    """Return the slip speed [m/s] of finger ``i``, NaN while it is not believed."""
    return math.nan if q[FELT_SPEED + 6 * i + FELT_OFF] > 0.0 else speed


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
    flag, fast = FELT_FLAG + 6 * i, FELT_SPEED + 6 * i
    follow_claim(q, flag, dt, flagged, u)
    follow_claim(q, fast, dt, slides, u)
    empty = flagged and speed < FELT_CREEP
    silent = slides and slip < 0.5 and twist < FELT_TWIST and q[fast + FELT_OFF] <= 0.0
    q[flag + FELT_AGAINST] = q[flag + FELT_AGAINST] + dt if empty else 0.0
    q[fast + FELT_AGAINST] = q[fast + FELT_AGAINST] + dt if silent else 0.0
    if q[flag + FELT_AGAINST] > FELT_EMPTY_TIME + q[FELT_DELAY]:
        distrust(q, flag, FELT_BY_OTHER)
    if q[fast + FELT_AGAINST] > FELT_SILENT_TIME + q[FELT_DELAY]:
        distrust(q, flag, FELT_SILENT)


def follow_claim(q: Numbers, at: int, dt: float, says: bool, u: float) -> None:
    """Follow the channel at ``at``, which ``says`` that the finger slides or not."""
    if not says:
        q[at + FELT_LASTS] = q[at + FELT_LOW] = q[at + FELT_BEGAN] = 0.0
        q[at + FELT_OFF] = max(q[at + FELT_OFF] - dt, 0.0)
        return
    q[at + FELT_LASTS] += dt
    if not 0.0 < u < math.inf:
        return
    if q[at + FELT_BEGAN] == 0.0:
        q[at + FELT_BEGAN] = u
    low = u < FELT_FALLEN * q[at + FELT_BEGAN]
    q[at + FELT_LOW] = q[at + FELT_LOW] + dt if low else 0.0
    if q[at + FELT_LOW] > FELT_FALLEN_TIME + q[FELT_DELAY]:
        distrust(q, at, FELT_BY_LOAD)


def distrust(q: Numbers, at: int, why: float) -> None:
    """Do not believe the channel at ``at`` for a while."""
    q[at + FELT_OFF], q[at + FELT_WHY] = FELT_DISTRUST, why
