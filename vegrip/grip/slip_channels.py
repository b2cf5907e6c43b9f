"""What the slip channels of a grasp say, and how likely each of them is sound, silent or faulty.

A finger has a flag and a slip speed, whose sign is a direction and which says slip from a stated speed on.
Each is one of three:

* *sound*: while its finger slides it says so with probability ``DETECTS``, else with ``FALSE`` a look;
* *silent*: it never says slip, as a dead one;
* *faulty*: it says slip whatever the finger does; it begins to as often as it has begun of late.

A *look* lasts ``LOOK``: what a channel says in between is the same noise. With the probability p that the
finger slides by all that is known beside this channel, what it says multiplies the three by::

    begins to say slip:                     p DETECTS + (1 - p) FALSE,  0,  how often it begins
    goes on, while w is still what it was:  DETECTS,                    0,  DETECTS
    goes on, though w has fallen:           FALSE a look,               0,  DETECTS
    has missed a slide that the load shows: 1 - q DETECTS,              1,  1

and a channel goes back to what is usual of such channels in ``RENEWED``: sensors are mended, and they break.

**A slide of finger i.** ``w = ln u + g l`` is its utilisation referred to the reference load; it slides where
``w > x_i``. Having just held ``h`` cuts off the belief of x, so without any channel::

    p = P(x < w + e | x > h - e),    at least RARE exp(-((h - w) / e)^2 / 2),    e^2 = SCATTER^2 + std^2

since friction may have changed, but not while w falls: a contact that slides has w = x. It is at least RARE
P(x + change < w + e) besides, with ``CHANGE_STD`` of the change: wet faces slide far below what they held
when dry. A contact has held nothing when it begins. While such a slide is believed, h is at most w at its
first report, the first for ``RETURN`` of any channel; and whether w has fallen counts from that report on,
believed or not. p is taken at its largest over the delay of the channels, because they tell late, and at
least ``EVEN`` times the probability that another finger slides by its own load and channels. A channel that
says slip for n looks adds to its logit::

    min(n ln 1 / FALSE, ln (1 + S DETECTS / (Y r))),     r how often it begins to say slip

because a sound one errs anew at each look, and a faulty one may go on. S and Y were its probabilities to be
sound and faulty when it began, and S falls with each look that goes on as above.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.estimator.normal_law import upper_tail
from vegrip.grip.friction_belief import *
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory


def begin_channels(g: GraspMemory, sliding: float, delay: float) -> None:
    """Set the slip speed [m/s] from which a finger slides, 0 = the flag alone tells, and the delay [s]."""
    g.slip.sliding, g.slip.delay = sliding, delay
    g.slip.exponent = g.belief.mean[int(g.belief.fingers)]
    for at in range(2 * BELIEF_MOST):
        g.slip.sound[at], g.slip.silent[at] = USUAL, EVEN
        g.slip.says[at], g.slip.silence[at] = math.nan, math.inf
        g.slip.rate[at], g.slip.odds[at] = RARE, math.nan
    for i in range(BELIEF_MOST):
        g.slip.level[i] = g.slip.held[i] = g.slip.shown[i] = g.slip.begun[i] = -math.inf
        g.slip.top[i] = g.slip.top_next[i] = -math.inf


def faulty(g: GraspMemory, at: int) -> float:
    """Return the probability that the channel at ``at`` is faulty."""
    return max(1.0 - g.slip.sound[at] - g.slip.silent[at], NEARLY_NONE)


def hear_slip(g: GraspMemory, i: int, dt: float, flag: float, speed: float) -> None:
    """Take in what finger ``i`` says of slip after ``dt`` [s]: its flag and its speed [m/s], or NaN."""
    fast = math.nan
    if g.slip.sliding > 0.0 and speed >= 0.0:
        fast = 1.0 if speed >= g.slip.sliding else 0.0
    hear_channel(g, i, i, dt, flag if flag <= 0.0 or flag >= 1.0 else math.nan)
    hear_channel(g, i, BELIEF_MOST + i, dt, fast)
    shows = shown_slide(g, i)
    g.slip.slides[i] = chance(logit(likely_slide(g, i)) + shows) if shows > 0.0 else 0.0


def shown_slide(g: GraspMemory, i: int) -> float:
    """Return what the channels of finger ``i`` add to the logit of its slide; both are of one sensor."""
    return max(g.slip.shows[i], g.slip.shows[BELIEF_MOST + i])


def likely_slide(g: GraspMemory, i: int) -> float:
    """Return p of finger ``i``, by its load and by what is known of each other finger without this one."""
    p = g.slip.likely[i]
    for j in range(int(g.belief.fingers)):
        if j != i and shown_slide(g, j) > 0.0:
            p = max(p, EVEN * chance(logit(g.slip.likely[j]) + shown_slide(g, j)))
    return p


def hear_channel(g: GraspMemory, i: int, at: int, dt: float, says: float) -> None:
    """Take in what the channel at ``at`` of finger ``i`` says: 1, 0, or NaN where it is not sensed."""
    before, g.slip.says[at] = g.slip.says[at], says
    looks = min(dt / LOOK, 1.0)
    usual = 1.0 - math.exp(-dt / RENEWED)
    g.slip.sound[at] += usual * (USUAL - g.slip.sound[at])
    g.slip.silent[at] += usual * (EVEN - g.slip.silent[at])
    g.slip.silence[at] += dt
    g.slip.rate[at] += looks / RENEWED * (RARE - g.slip.rate[at])
    if not says >= 0.5:
        g.slip.shows[at] = 0.0
        if says >= 0.0:
            g.slip.odds[at] = 0.0
        return
    if last_told(g) > RETURN:
        for j in range(int(g.belief.fingers)):
            g.slip.begun[j] = g.slip.level[j]
    g.slip.silence[at] = 0.0
    if before >= 0.5:
        tells = g.slip.stays[i] * DETECTS + (1.0 - g.slip.stays[i]) * FALSE
        weigh(g, at, math.exp(looks * math.log(tells)), NEARLY_NONE, math.exp(looks * math.log(DETECTS)))
        g.slip.odds[at] *= math.exp(looks * math.log(tells / DETECTS))
    else:
        p = likely_slide(g, i)
        rate = EVEN if math.isnan(g.slip.odds[at]) else g.slip.rate[at]  # it may have said so all the time
        g.slip.odds[at] = g.slip.sound[at] * DETECTS / (faulty(g, at) * rate)
        weigh(g, at, p * DETECTS + (1.0 - p) * FALSE, NEARLY_NONE, rate)
        g.slip.rate[at] += (1.0 - g.slip.rate[at]) / RENEWED
    g.slip.shows[at] = min(g.slip.shows[at] - looks * math.log(FALSE), math.log(1.0 + g.slip.odds[at]))


def last_told(g: GraspMemory) -> float:
    """Return how long ago some channel of the grasp last said slip [s]."""
    last = math.inf
    for i in range(int(g.belief.fingers)):
        last = min(last, g.slip.silence[i])
        last = min(last, g.slip.silence[BELIEF_MOST + i])
    return last


def weigh(g: GraspMemory, at: int, sound: float, silent: float, faults: float) -> None:
    """Multiply the probabilities of a channel by these likelihoods."""
    sound *= max(g.slip.sound[at], NEARLY_NONE)
    silent *= max(g.slip.silent[at], NEARLY_NONE)
    faults *= faulty(g, at)
    total = sound + silent + faults
    g.slip.sound[at], g.slip.silent[at] = sound / total, silent / total


def judge_slide(g: GraspMemory, since: float, p: float) -> None:
    """Weigh who has told that the object has slid ``since`` [s] ago, which is so with probability ``p``.

    Where one has, it may have been a slide of its finger alone, which the others need not tell.
    """
    last = last_told(g)
    for i in range(int(g.belief.fingers)):
        for k in range(2):
            at = i + k * BELIEF_MOST
            if g.witness.forces[i] <= 0.0:  # what does not touch does not slide
                continue
            if g.slip.silence[at] <= since:
                weigh(g, at, p * DETECTS + (1.0 - p) * RARE, NEARLY_NONE, RARE)
            elif last > since and not math.isnan(g.slip.says[at]):
                weigh(g, at, 1.0 - p * DETECTS, 1.0, 1.0)


def follow_utilisation(
    g: GraspMemory, i: int, dt: float, u: float, unsure: float, load: float, touching: bool
) -> float:
    """Note how likely finger ``i`` slides by its load; return the relative std of the averaged utilisation.

    Args:
        g: what the grasp shares.
        i: the finger.
        dt: [s] since the last sample.
        u: utilisation at mu = 1; NaN where it is not known.
        unsure: its relative std.
        load: relative load of the finger.
        touching: whether it touches: in the air nothing slides, and of a light touch it is not known.

    """
    g.slip.held[i] -= dt / HELD_TIME
    if not (0.0 < u < math.inf and unsure < math.inf):
        g.slip.level[i] = g.slip.shown[i] = -math.inf
        if not touching:
            g.slip.held[i] = -math.inf
        remember(g, i, dt, RARE if touching else FALSE, -math.inf, others_stay(g, i) if touching else 0.0)
        return math.inf
    relative = math.exp(-g.belief.mean[int(g.belief.fingers)] * load)
    spread = u * unsure
    if g.slip.level[i] > -math.inf:
        old = math.exp(-dt / LOOK)
        u += old * (math.exp(g.slip.level[i]) * relative - u)
        spread += old * (g.slip.spread[i] - spread)
    u = max(u, NEARLY_NONE)
    g.slip.spread[i], unsure = spread, spread / u
    w = g.slip.level[i] = math.log(u / relative)
    if unsure > EVEN:
        remember(g, i, dt, RARE, -math.inf, others_stay(g, i))
        return unsure
    near, std = math.hypot(SCATTER, unsure), math.sqrt(believed_variance(g, i) + NEARLY_NONE)
    was = g.slip.held[i]
    began = min(was, g.slip.begun[i]) if g.slip.begun[i] > -math.inf else was
    if g.slip.slides[i] >= EVEN:
        was = began
    low = (was - near - g.belief.mean[i]) / std
    high = (w + near - g.belief.mean[i]) / std
    p = 1.0 - upper_tail(high) / upper_tail(low) if high > low else 0.0
    stays = as_before((was - w) / near)
    changed = max(stays, upper_tail((g.belief.mean[i] - w - near) / math.hypot(std, CHANGE_STD)))
    if last_told(g) <= RETURN:
        stays = as_before((began - w) / near)
    remember(g, i, dt, min(max(p, RARE * changed, FALSE), SURE), w, stays)
    rises = w - CREDIBLE * unsure
    rises = min(rises, g.slip.shown[i] + QUICK * dt) if g.slip.shown[i] > -math.inf else rises
    rises = min(rises, g.belief.mean[i] + CREDIBLE * std)
    g.slip.held[i] = max(g.slip.held[i], rises)
    if g.slip.slides[i] < EVEN:
        g.slip.shown[i] = rises
    return unsure


def as_before(fallen: float) -> float:
    """Return how far a utilisation is what it was that has ``fallen`` by so many standard deviations."""
    return math.exp(-0.5 * fallen * fallen) if fallen > 0.0 else 1.0


def refer_anew(g: GraspMemory) -> None:
    """Refer what was seen of utilisations to the reference load by the exponent that is believed now.

    A slide of one finger teaches the exponent, and what the others have held is not less for that.
    """
    exponent = g.belief.mean[int(g.belief.fingers)]
    moved = exponent - g.slip.exponent
    g.slip.exponent = exponent
    if moved == 0.0:
        return
    for i in range(int(g.belief.fingers)):
        more = moved * g.belief.load[i]
        g.slip.level[i] += more
        g.slip.held[i] += more
        g.slip.shown[i] += more
        g.slip.begun[i] += more
        g.slip.top[i] += more
        g.slip.top_next[i] += more
        g.belief.record[i] += moved * g.belief.site_load[i]


def others_stay(g: GraspMemory, i: int) -> float:
    """Return whether finger ``i``, of which too little is known, may go on sliding as the others may."""
    found = -1.0
    for j in range(int(g.belief.fingers)):
        if j != i and g.slip.held[j] > -math.inf:
            found = max(found, g.slip.stays[j])
    return max(found, 0.0) if found >= 0.0 else 1.0


def remember(g: GraspMemory, i: int, dt: float, p: float, w: float, stays: float) -> None:
    """Keep the largest chance of a slide, and the largest utilisation, of the last one or two delays."""
    g.slip.likely_age[i] += dt
    if g.slip.likely_age[i] > g.slip.delay + 2.0 * LOOK:
        g.slip.likely_age[i] = 0.0
        g.slip.likely[i], g.slip.top[i] = g.slip.likely_next[i], g.slip.top_next[i]
        g.slip.stays[i] = g.slip.stays_next[i]
        g.slip.likely_next[i], g.slip.top_next[i], g.slip.stays_next[i] = p, w, stays
    g.slip.stays_next[i] = max(g.slip.stays_next[i], stays)
    g.slip.stays[i] = max(g.slip.stays[i], g.slip.stays_next[i])
    g.slip.likely_next[i] = max(g.slip.likely_next[i], p)
    g.slip.top_next[i] = max(g.slip.top_next[i], w)
    g.slip.likely[i] = max(g.slip.likely[i], g.slip.likely_next[i])
    g.slip.top[i] = max(g.slip.top[i], g.slip.top_next[i])


def sound_channel(g: GraspMemory, i: int) -> float:
    """Return the probability that a channel of finger ``i`` that is sensed is sound."""
    flag, fast = i, BELIEF_MOST + i
    found = g.slip.sound[flag] if g.slip.says[flag] >= 0.0 else 0.0
    return max(found, g.slip.sound[fast]) if g.slip.says[fast] >= 0.0 else found


def noticed(g: GraspMemory) -> float:
    """Return the probability that a slide of the object would be told: it is one of all fingers."""
    found = 0.0
    for i in range(int(g.belief.fingers)):
        if g.witness.forces[i] > 0.0:
            found = max(found, sound_channel(g, i))
    return found


def is_unsound(g: GraspMemory, at: int) -> bool:
    """Return whether the channel at ``at`` is surely not sound."""
    return g.slip.sound[at] < NAMED_AT


def has_unsound(g: GraspMemory) -> bool:
    """Return whether some channel of the grasp that is sensed is surely not sound."""
    for at in range(2 * BELIEF_MOST):  # noqa: SIM110 (compiled)
        if g.slip.says[at] >= 0.0 and is_unsound(g, at):
            return True
    return False


def teller(g: GraspMemory, i: int) -> int:
    """Return the channel by which it is believed that finger ``i`` slides."""
    return i if g.slip.shows[i] >= g.slip.shows[BELIEF_MOST + i] else BELIEF_MOST + i


def chance(x: float) -> float:
    """Return the probability of a logit."""
    return 1.0 / (1.0 + math.exp(-min(max(x, -50.0), 50.0)))


def logit(p: float) -> float:
    """Return the logit of a probability, which is taken to be within FALSE of 0 and 1."""
    p = min(max(p, FALSE), 1.0 - FALSE)
    return math.log(p / (1.0 - p))
