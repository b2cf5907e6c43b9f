"""Whether felt slip is proven in this run, and what the load shows of a slide that no channel tells.

Force is let go of below what the prior asks for only where a slide would be felt. A dead channel says what a
sound one says while nothing slides, so silence proves nothing. The grasp **trusts** felt slip while one of
its channels has been heard at a slide within ``TRUST_LASTS``: a slide of the object is one of all fingers.
What proves the channel of a finger is slip that its flag tells, since that alone teaches friction,

* after ``TRUST_SILENCE`` of silence,
* while the finger is let go of, so that slip is expected, and
* at the largest utilisation it has had of late, where a contact slides and a random flag seldom falls.

Until then every finger counts on no more than the prior (:func:`counted_shift`), and the fingers are let go
of together, for the proof alone, while the load watches: of an object that is not known as far as it takes
to slide.

**The load as a witness.** Let N be the sum of the normal forces and f that of the tangential forces. While
contacts hold, f stays as N is let go of; what one finger gives up the others take. When the object slides,
f = mu N. So ``y = w ln N - ln f`` rises by 1 - w of the fall of ln N where it slides, and falls by w of it
where it holds. A rise of y by ``TRUST_RISE``, or by ``TRUST_NOISE`` standard deviations of its noise, above
its least of late ends the probe. A load that fades, which the grip follows, looks the same, but N falls more
than ``TRUST_FADING`` times as far as f. Else every finger counts on no more than the prior for
``TRUST_HOLD``. A fall of f / N by as much, below its largest within ``TRUST_TORN_TIME``, ends the probe as
well: a contact that begins to slide may hold less than one that rests. It was a slide

* if f comes back with N, ``TRUST_SEEN`` and the delay that felt slip is told to have after N is back at
  ``TRUST_MORE`` of what it was, within ``TRUST_JUDGED``,
* and f / N has not come back, nor fallen below ``TRUST_FAR`` of what it was before N is back: a contact that
  slides carries its friction times N, neither more nor much less;
* and no finger has told slip since ``TRUST_BEFORE`` before, at ``TRUST_FAR`` or more of the utilisation that
  has just held: a channel that is late tells it when the grip is back.

Then the channels are deaf: what they have proven is void, and they are not used for ``TRUST_DEAF``, the next
time for ``TRUST_DEAD``.

A slide while N falls slowly would show too late: below ``TRUST_SLOW`` of ln N a second what was let go of is
taken back. The quick fall before has shown no slide, so while felt slip is trusted no more is taken back than
``TRUST_RETREAT``, then and when a load changes, until a finger slips. A load that holds also raises the
belief; by so much less is let go of, lest it counts twice and the grip rests at the limit.

A flag that tells slip again and again below ``TRUST_FAR`` of the utilisation that has just held contradicts
the load, and is not used. What any flag has taught is void when it is found to contradict load or slip speed:
then the friction of all fingers is again what was expected of it, or a std above what was believed when no
flag had told slip for ``TRUST_CLEAN_TIME``, where that is lower.

Where the slip speed has shown noise, a speed that is exactly the same for ``TRUST_STILL`` samples, or is
gone, is no measurement, and voids the proof as well.

Plain scalar code over the flat sequence of :mod:`~vegrip.grip.friction_probe`, behind the section of
:mod:`~vegrip.grip.friction_change`; the same text is compiled.
"""

import math

from vegrip.grip.friction_change import *
from vegrip.types import Numbers

TRUST_HELD = CHANGE_SIZE  # [s] for which the grasp still counts on the prior after the load has shown a slide
TRUST_LEAST = CHANGE_SIZE + 1  # least y of late; inf: no finger is let go of
TRUST_LOAD = CHANGE_SIZE + 2  # [N] f when y was least
TRUST_GRIP = CHANGE_SIZE + 3  # [N] N when y was least
TRUST_FELL = CHANGE_SIZE + 4  # [N] by which f had fallen when the load showed a slide
TRUST_WAIT = CHANGE_SIZE + 5  # [s] until that is judged; 0: nothing is to be judged
TRUST_MISSED = CHANGE_SIZE + 6  # slides that no channel told, since the last one that one told
TRUST_FIRST = CHANGE_SIZE + 7  # [N] N when force began to be let go of
TRUST_LATER = CHANGE_SIZE + 8  # [N] N that lags
TRUST_RATIO = CHANGE_SIZE + 9  # f / N that lags
TRUST_TORN = CHANGE_SIZE + 10  # f / N when the load showed a slide
TRUST_PRIOR = CHANGE_SIZE + 11  # mean ln mu of finger i before anything was felt
TRUST_SPREAD = TRUST_PRIOR + BELIEF_MOST  # its std
TRUST_PROOF = TRUST_SPREAD + BELIEF_MOST  # [s] for which the proof of finger i still counts
TRUST_TOP = TRUST_PROOF + BELIEF_MOST  # largest utilisation of late
TRUST_PULL = TRUST_TOP + BELIEF_MOST  # [N] smoothed tangential force; 0: the finger does not touch
TRUST_FORCE = TRUST_PULL + BELIEF_MOST  # [N] smoothed normal force
TRUST_SPEED = TRUST_FORCE + BELIEF_MOST  # [m/s] last slip speed
TRUST_CONSTANT = TRUST_SPEED + BELIEF_MOST  # samples for which it has been exactly that
TRUST_NOISY = TRUST_CONSTANT + BELIEF_MOST  # changes of it while nothing slid
TRUST_FALSE = TRUST_NOISY + BELIEF_MOST  # slips of late that it told far below what it had held
TRUST_VOID = TRUST_FALSE + BELIEF_MOST  # 1 where what it has taught is void, its flag being wrong
TRUST_RIM = TRUST_VOID + BELIEF_MOST  # [s] for which it has slid by its slip speed alone
TRUST_KEPT = TRUST_RIM + BELIEF_MOST  # of what it was let go of, what the load has shown to hold
TRUST_CLEAN = TRUST_KEPT + BELIEF_MOST  # mean ln mu when no flag had told slip for a while
TRUST_MEAN = TRUST_CLEAN + BELIEF_MOST  # mean ln mu at the last sample
TRUST_TOLD = TRUST_MEAN + BELIEF_MOST  # [s] since it told slip where it may have slid
TRUST_SIZE = TRUST_TOLD + BELIEF_MOST

TRUST_LASTS = 60.0  # [s]
TRUST_SILENCE = 0.5  # [s]
TRUST_NEAR = 0.7  # of the largest utilisation of late
TRUST_FAR = 0.8  # of the same, below which a contact that has just held does not slide
TRUST_FALSE_MOST = 2.5  # times that it may tell so, friction falling
TRUST_FALSE_TIME = 5.0  # [s] in which that is forgotten
TRUST_FLAG_LATER = 0.03  # [s] than the slip speed
TRUST_TOP_TIME = 1.0  # [s] in which that is forgotten
TRUST_SHARE = 0.3  # w
TRUST_RISE = 0.03
TRUST_LATER_TIME = 0.15  # [s]
TRUST_TORN_TIME = 0.05  # [s]
TRUST_SLOW = 0.25  # [1/s] of ln N
TRUST_BEGUN = 0.95  # of N at first, from which on it must fall that fast
TRUST_ALIKE = 0.5  # of the fall of ln f, that ln N must have fallen by: else the load has changed
TRUST_FADING = 1.6  # of the same, beyond which the load fades and the grip only follows it
TRUST_NOISE = 5.0  # standard deviations
TRUST_BLIND = 0.15  # rise of y beyond which noise hides a slide for too long, so that force is not let go of
TRUST_FORGET = 0.6  # [s] in which the least y is forgotten: a slow load shows no slide
TRUST_AHEAD = 1.7  # of ln mu
TRUST_CLIMB = 2.5  # times as fast as an unknown object is let go of that is trusted
TRUST_HOLD = 0.3  # [s]
TRUST_CLEAN_TIME = 2.0  # [s]
TRUST_JUDGED = 0.12  # [s]
TRUST_SEEN = 0.03  # [s] after N has come back
TRUST_BEFORE = 0.1  # [s]
TRUST_RETREAT = 0.12  # of ln mu, from where a quick fall of N has shown no slide
TRUST_BACK = 0.6  # of what was lost, that must be back
TRUST_MORE = 1.15  # times N before it, with which it must be
TRUST_DEAF = 10.0  # [s]
TRUST_DEAD = 300.0  # [s]
TRUST_STILL = 40.0  # samples
TRUST_LIVELY = 50.0  # changes that show noise


def begin_trust(g: Numbers, q: Numbers) -> None:
    """Trust nothing yet, and take what is expected of friction now as the prior."""
    for j in range(TRUST_SIZE - TRUST_HELD):
        q[TRUST_HELD + j] = 0.0
    q[TRUST_LEAST] = math.inf
    for i in range(BELIEF_MOST):
        q[TRUST_PRIOR + i] = q[TRUST_CLEAN + i] = q[TRUST_MEAN + i] = g[BELIEF_MEAN + i]
        q[TRUST_SPREAD + i] = math.sqrt(believed_variance(g, i))


def trusts_slip(g: Numbers, q: Numbers) -> bool:
    """Return whether a slide of the object would be felt."""
    if q[TRUST_HELD] > 0.0:
        return False
    longest = 0.0
    for i in range(int(g[BELIEF_FINGERS])):
        longest = max(longest, q[TRUST_PROOF + i])
    return longest > 0.0


def counted_shift(g: Numbers, q: Numbers, i: int, lag: float) -> float:
    """Return what finger ``i`` counts on above the lower bound of its friction, of ln mu.

    Felt slip that is not trusted lets no bound rise above that of the prior; ``lag`` is how many standard
    deviations are counted off the means.
    """
    if trusts_slip(g, q):
        return q[PROBE_SHIFT + i]
    return q[PROBE_SHIFT + i] + min(0.0, prior_bound(q, i, lag) - believed_bound(g, i, lag))


def prior_bound(q: Numbers, i: int, lag: float) -> float:
    """Return the lower bound of ln mu before anything was felt."""
    return q[TRUST_PRIOR + i] - lag * q[TRUST_SPREAD + i]


def believed_bound(g: Numbers, i: int, lag: float) -> float:
    """Return the lower bound of ln mu as it is believed."""
    return g[BELIEF_MEAN + i] - lag * math.sqrt(believed_variance(g, i))


def counts_as_known(g: Numbers, q: Numbers, i: int) -> bool:
    """Return whether finger ``i`` may count on more of its friction than one whose slip is not felt.

    Its slip is sensed, a slide of the object would be felt, and the object is not unknown any more: what is
    lifted has taught nothing yet.
    """
    known = believed_variance(g, i) <= q[PROBE_UNKNOWN] * q[PROBE_UNKNOWN]
    return known and is_heard(q, i) and trusts_slip(g, q)


def let_go(
    g: Numbers,
    q: Numbers,
    i: int,
    dt: float,
    lag: float,
    asked: float,
    u: float,
    noise: float,
    touching: bool,
    slipping: bool,
) -> None:
    """Let go of finger ``i`` where it may be.

    Args:
        g: the belief.
        q: the state.
        i: the finger.
        dt: [s] since the last sample.
        lag: how many std are counted off the mean.
        asked: margin that it was asked to keep, what it was let go of counted in [-].
        u: utilisation at mu = 1; no farther ahead of it than ``TRUST_AHEAD``, lest a slide runs away.
        noise: std of the tangential force [N]; that must be large enough to show a slide.
        touching: whether it touches.
        slipping: whether it slips.

    """
    if not is_heard(q, i) or rise_of_slide(g, q, dt, noise) > TRUST_BLIND:
        q[PROBE_SHIFT + i] = 0.0
    elif touching and not slipping and u > 0.0:
        if believed_bound(g, i, lag) + math.log(1.0 - asked) > math.log(u) + TRUST_AHEAD:
            return
        if trusts_slip(g, q):
            probe_friction(g, q, i, dt, lag)
        elif q[TRUST_HELD] <= 0.0 and seeks_proof(g, q, i) and is_quiet(q, int(g[BELIEF_FINGERS])):
            std, shift = math.sqrt(believed_variance(g, i)), q[PROBE_SHIFT + i]
            most = math.inf  # of an object that is not known, it is not known either where it slides
            if std <= q[PROBE_UNKNOWN]:
                low = min(prior_bound(q, i, lag), believed_bound(g, i, lag))
                most = g[BELIEF_MEAN + i] + q[PROBE_REACH] * std - low
            q[PROBE_SHIFT + i] = min(shift + TRUST_CLIMB * q[PROBE_CLIMB] * dt, max(most, shift))


def ends_probe(q: Numbers, i: int, dt: float, slipping: bool, sliding: bool) -> bool:
    """Return whether finger ``i`` slides by its flag, or for a while by its slip speed alone.

    The rim of a patch slides before all of it does, so the flag, which alone proves and teaches, comes later.
    """
    q[TRUST_RIM + i] = q[TRUST_RIM + i] + dt if sliding and not slipping else 0.0
    if slipping or q[TRUST_RIM + i] > TRUST_FLAG_LATER + q[FELT_DELAY]:
        keep_nothing(q)
        return True
    return False


def seeks_proof(g: Numbers, q: Numbers, i: int) -> bool:
    """Return whether finger ``i`` may be let go of to prove its channel.

    Where its slip speed shows noise it may with the others. Else one finger of three or more may, alone and
    beside the thumb, since the others hold what it gives up.
    """
    if q[TRUST_NOISY + i] >= TRUST_LIVELY:
        return True
    n = int(g[BELIEF_FINGERS])
    return n > 2 and i > 0 and whole(g, q, PROBE_SHIFT) <= q[PROBE_SHIFT + i]


def follow_trust(
    g: Numbers,
    q: Numbers,
    i: int,
    dt: float,
    flag: float,
    speed: float,
    u: float,
    relative: float,
    force: float,
    pull: float,
    noise: float,
    touching: bool,
) -> None:
    """Take in one sample of finger ``i``.

    Args:
        g: the belief.
        q: the state.
        i: the finger.
        dt: [s] since the last sample.
        flag: slip flag, as far as it is believed; it alone teaches friction, so it alone is proven.
        speed: slip speed as it is sensed [m/s]; NaN = not measured.
        u: utilisation at mu = 1.
        relative: its relative std.
        force: normal force [N].
        pull: tangential force [N].
        noise: std of that [N].
        touching: whether it touches.

    """
    q[TRUST_PROOF + i] = max(q[TRUST_PROOF + i] - dt, 0.0)
    watch_constant(g, q, i, speed)
    void_lies(g, q, i)
    count_once(g, q, i)
    if not touching:
        q[TRUST_TOP + i] = q[TRUST_FORCE + i] = q[TRUST_PULL + i] = 0.0
    else:
        known = u if relative < ONSET_VAGUE else 0.0
        q[TRUST_FALSE + i] *= math.exp(-dt / TRUST_FALSE_TIME)
        q[TRUST_TOLD + i] += dt
        if (flag >= 0.5 or shows_sliding(q, speed)) and may_slide(q, i, known):
            q[TRUST_TOLD + i] = 0.0
        if flag >= 0.5:
            hear_slide(q, i, known)
        q[TRUST_TOP + i] = max(known, q[TRUST_TOP + i] * math.exp(-dt / TRUST_TOP_TIME))
        if force > 0.0 and pull >= 0.0:
            part = 1.0 - math.exp(-dt / SMOOTHING) if q[TRUST_FORCE + i] > 0.0 else 1.0
            q[TRUST_FORCE + i] += part * (force - q[TRUST_FORCE + i])
            q[TRUST_PULL + i] += part * (pull - q[TRUST_PULL + i])
    if q[PROBE_STILL + i] == 0.0:
        take_back(g, q)
    watch_slide(g, q, dt, noise)


def hear_slide(q: Numbers, i: int, u: float) -> None:
    """The flag of finger ``i`` tells slip at ``u``, 0 = not known: that proves it, or tells against it."""
    flag, top = FELT_FLAG + FELT_WIDTH * i, q[TRUST_TOP + i]
    silent = q[flag + FELT_QUIET]
    is_expected = q[PROBE_SHIFT + i] - q[TRUST_KEPT + i] > LEAST_PROBE and u >= TRUST_NEAR * top
    if is_expected and silent >= TRUST_SILENCE:
        q[TRUST_PROOF + i], q[TRUST_MISSED] = TRUST_LASTS, 0.0
    if u > 0.0 and silent > 0.0 and not may_slide(q, i, u):
        q[TRUST_FALSE + i] += 1.0
        if q[TRUST_FALSE + i] > TRUST_FALSE_MOST:
            distrust(q, flag, FELT_BY_LOAD, FELT_DISTRUST)


def may_slide(q: Numbers, i: int, u: float) -> bool:
    """Return whether finger ``i`` may have slid at ``u``: not far below what has just held it."""
    return not u < TRUST_FAR * q[TRUST_TOP + i]


def is_constant(q: Numbers, i: int) -> bool:
    """Return whether the slip speed of finger ``i`` is exactly the same, or not sensed, for a while."""
    return q[TRUST_CONSTANT + i] > TRUST_STILL


def void_lies(g: Numbers, q: Numbers, i: int) -> None:
    """Forget what the fingers have learned when the flag of finger ``i`` has just been found to be wrong.

    Friction that was low before any flag lied is expected to be no more than a standard deviation higher.
    """
    flag = FELT_FLAG + FELT_WIDTH * i
    is_off = q[flag + FELT_OFF] > 0.0
    silent = math.inf
    for j in range(int(g[BELIEF_FINGERS])):
        silent = min(silent, q[FELT_FLAG + FELT_WIDTH * j + FELT_QUIET])
    if silent >= TRUST_CLEAN_TIME:
        q[TRUST_CLEAN + i] = g[BELIEF_MEAN + i]
    if is_off and q[TRUST_VOID + i] == 0.0 and q[flag + FELT_WHY] != FELT_DEAF:
        q[TRUST_PROOF + i] = 0.0
        for j in range(int(g[BELIEF_FINGERS])):
            forget_evidence(g, j, min(q[TRUST_PRIOR + j], q[TRUST_CLEAN + j] + q[TRUST_SPREAD + j]))
    q[TRUST_VOID + i] = 1.0 if is_off else 0.0


def watch_constant(g: Numbers, q: Numbers, i: int, speed: float) -> None:
    """Void the proof of finger ``i`` where its slip speed, which was noisy, is a constant now, or is gone."""
    if speed == q[TRUST_SPEED + i] or math.isnan(speed):
        q[TRUST_CONSTANT + i] += 1.0
        if is_constant(q, i) and q[TRUST_NOISY + i] >= TRUST_LIVELY:
            q[TRUST_NOISY + i] = q[TRUST_PROOF + i] = 0.0
            take_back(g, q)
    else:
        q[TRUST_NOISY + i] = min(q[TRUST_NOISY + i] + 1.0, TRUST_LIVELY)
        q[TRUST_SPEED + i], q[TRUST_CONSTANT + i] = speed, 0.0


def whole(g: Numbers, q: Numbers, first: int) -> float:
    """Return the sum of what the fingers have from ``first`` on."""
    total = 0.0
    for i in range(int(g[BELIEF_FINGERS])):
        total += q[first + i]
    return total


def rise_of_slide(g: Numbers, q: Numbers, dt: float, noise: float) -> float:
    """Return the rise of y that noise does not make; ``dt`` [s] is from sample to sample of one finger."""
    pull = whole(g, q, TRUST_PULL)
    if not (pull > 0.0 and dt > 0.0):
        return math.inf
    std = noise * math.sqrt(g[BELIEF_FINGERS] * dt / (dt + 2.0 * SMOOTHING))
    return max(TRUST_RISE, TRUST_NOISE * std / pull)


def watch_slide(g: Numbers, q: Numbers, dt: float, noise: float) -> None:
    """Look whether the load shows a slide, and judge the last one that it has shown."""
    part = dt / g[BELIEF_FINGERS]
    q[TRUST_HELD] = max(q[TRUST_HELD] - part, 0.0)
    force, pull = whole(g, q, TRUST_FORCE), whole(g, q, TRUST_PULL)
    if q[TRUST_WAIT] > 0.0 and holds_after_all(q, pull, force):
        q[TRUST_WAIT] = 0.0
    if q[TRUST_WAIT] > 0.0:
        q[TRUST_WAIT] -= part
        if q[TRUST_GRIP] > 0.0 and force >= TRUST_MORE * q[TRUST_GRIP]:
            q[TRUST_GRIP], q[TRUST_WAIT] = 0.0, min(q[TRUST_WAIT], TRUST_SEEN + q[FELT_DELAY])
        is_back = pull >= q[TRUST_LOAD] - (1.0 - TRUST_BACK) * q[TRUST_FELL]
        if q[TRUST_WAIT] <= 0.0 and q[TRUST_GRIP] == 0.0 and is_back:
            judge_slide(g, q)
        return
    let = whole(g, q, PROBE_SHIFT) - whole(g, q, TRUST_KEPT)
    if not (let > LEAST_PROBE and force > 0.0 and pull > 0.0):
        q[TRUST_LEAST] = math.inf
        q[TRUST_FIRST] = q[TRUST_LATER] = max(force, 0.0)
        q[TRUST_RATIO] = 0.0
        return
    if has_torn(q, pull, force, part, rise_of_slide(g, q, dt, noise)):
        q[TRUST_RATIO], q[TRUST_LEAST] = 0.0, math.inf
        take_back(g, q)
        await_slip(q, pull, force)
        return
    if is_slow(q, force, part):
        keep_held(g, q)
        take_back(g, q)
        q[PROBE_SINCE_SLIP] = 0.0
        return
    y = TRUST_SHARE * math.log(force) - math.log(pull)
    forgotten = 1.0 - math.exp(-part / TRUST_FORGET)
    if y > q[TRUST_LEAST] and y - q[TRUST_LEAST] > rise_of_slide(g, q, dt, noise):
        if math.log(q[TRUST_GRIP] / force) >= TRUST_ALIKE * math.log(q[TRUST_LOAD] / pull):
            keep_nothing(q)
            take_back(g, q)
            q[PROBE_SINCE_SLIP], q[TRUST_LEAST] = 0.0, math.inf
            if math.log(q[TRUST_GRIP] / force) <= TRUST_FADING * math.log(q[TRUST_LOAD] / pull):
                q[TRUST_HELD] = TRUST_HOLD
                await_slip(q, pull, force)
            return
        forgotten = 1.0
    if y <= q[TRUST_LEAST]:
        forgotten = 1.0
        q[TRUST_LEAST] = y
    q[TRUST_LEAST] += forgotten * (y - q[TRUST_LEAST])
    q[TRUST_LOAD] += forgotten * (pull - q[TRUST_LOAD])
    q[TRUST_GRIP] += forgotten * (force - q[TRUST_GRIP])


def await_slip(q: Numbers, pull: float, force: float) -> None:
    """Wait for a channel to tell the slide in which f has fallen to ``pull`` [N] at N = ``force`` [N]."""
    q[TRUST_WAIT], q[TRUST_FELL] = TRUST_JUDGED + q[FELT_DELAY], q[TRUST_LOAD] - pull
    q[TRUST_TORN] = pull / force


def holds_after_all(q: Numbers, pull: float, force: float) -> bool:
    """Return whether f, ``pull`` [N] now, was a load that changed and no slide: then f / N would be friction.

    It has risen again, or is far below friction before N is back.
    """
    ratio = pull / force if force > 0.0 else 0.0
    is_back = ratio > q[TRUST_TORN] * (1.0 + TRUST_BACK * q[TRUST_FELL] / q[TRUST_LOAD])
    is_gone = ratio < TRUST_FAR * q[TRUST_TORN] and force < TRUST_MORE * q[TRUST_GRIP]
    return is_back or is_gone


def is_slow(q: Numbers, force: float, dt: float) -> bool:
    """Return whether N, ``force`` [N] now, falls so slowly that its fall would not show a slide in time."""
    q[TRUST_LATER] += (1.0 - math.exp(-dt / TRUST_LATER_TIME)) * (force - q[TRUST_LATER])
    rate = math.log(q[TRUST_LATER] / force) / TRUST_LATER_TIME
    return force < TRUST_BEGUN * q[TRUST_FIRST] and rate < TRUST_SLOW


def has_torn(q: Numbers, pull: float, force: float, dt: float, rise: float) -> bool:
    """Return whether f, ``pull`` [N] now, has fallen at once, and more than N, as when a slide begins."""
    ratio = pull / force
    lagging = q[TRUST_RATIO] + (1.0 - math.exp(-dt / TRUST_TORN_TIME)) * (ratio - q[TRUST_RATIO])
    q[TRUST_RATIO] = max(ratio, lagging)
    least = math.exp(-rise)
    return ratio < least * q[TRUST_RATIO] and pull < least * q[TRUST_LOAD]


def take_back(g: Numbers, q: Numbers) -> None:
    """Take back at once what all fingers were let go of, down to what the load has shown to hold."""
    if not trusts_slip(g, q):
        keep_nothing(q)
    for i in range(int(g[BELIEF_FINGERS])):
        q[PROBE_SHIFT + i] = min(q[PROBE_SHIFT + i], q[TRUST_KEPT + i])


def count_once(g: Numbers, q: Numbers, i: int) -> None:
    """Let go of finger ``i`` by so much less as its belief has risen: a load that held counts once."""
    rise = max(g[BELIEF_MEAN + i] - q[TRUST_MEAN + i], 0.0)
    q[TRUST_MEAN + i] = g[BELIEF_MEAN + i]
    q[PROBE_SHIFT + i] = max(q[PROBE_SHIFT + i] - rise, 0.0)
    q[TRUST_KEPT + i] = max(q[TRUST_KEPT + i] - rise, 0.0)


def keep_held(g: Numbers, q: Numbers) -> None:
    """Note that N has fallen quickly and no slide was seen: the contacts hold with little more than that."""
    for i in range(int(g[BELIEF_FINGERS])):
        q[TRUST_KEPT + i] = max(q[PROBE_SHIFT + i] - TRUST_RETREAT, q[TRUST_KEPT + i])


def keep_nothing(q: Numbers) -> None:
    """Forget with what the contacts have held."""
    for i in range(BELIEF_MOST):
        q[TRUST_KEPT + i] = 0.0


def judge_slide(g: Numbers, q: Numbers) -> None:
    """Decide whether the object slid and no channel told it."""
    q[TRUST_WAIT] = 0.0
    n = int(g[BELIEF_FINGERS])
    silent = math.inf
    for i in range(n):
        silent = min(silent, q[TRUST_TOLD + i])
    heard = silent < TRUST_JUDGED + q[FELT_DELAY] + TRUST_BEFORE
    if heard:
        return
    q[TRUST_MISSED] += 1.0
    lasts = TRUST_DEAF if q[TRUST_MISSED] < 2.0 else TRUST_DEAD
    for i in range(n):
        q[TRUST_PROOF + i] = 0.0
        distrust(q, FELT_FLAG + FELT_WIDTH * i, FELT_DEAF, lasts)
        distrust(q, FELT_SPEED + FELT_WIDTH * i, FELT_DEAF, lasts)
