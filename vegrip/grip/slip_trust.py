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

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.grip.friction_change import *
from vegrip.grip.grasp_memory import BELIEF_MOST, BELIEF_ROW, GraspMemory

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


def begin_trust(g: GraspMemory) -> None:
    """Trust nothing yet, and take what is expected of friction now as the prior."""
    g.trust.held = g.trust.load = g.trust.grip = g.trust.fell = g.trust.wait = g.trust.missed = 0.0
    g.trust.first = g.trust.later = g.trust.ratio = g.trust.torn = 0.0
    g.trust.least = math.inf
    n = int(g.belief.fingers)
    g.trust.exponent, g.trust.exponent_var = g.belief.mean[n], g.belief.p[n * BELIEF_ROW + n]
    for i in range(BELIEF_MOST):
        g.trust.prior[i] = g.trust.clean[i] = g.trust.mean[i] = g.belief.mean[i]
        g.trust.spread[i] = math.sqrt(believed_variance(g, i))
        g.trust.proof[i] = g.trust.top[i] = g.trust.pull[i] = g.trust.force[i] = g.trust.speed[i] = 0.0
        g.trust.constant[i] = g.trust.noisy[i] = g.trust.false[i] = g.trust.void[i] = g.trust.rim[i] = 0.0
        g.trust.kept[i] = g.trust.told[i] = 0.0


def trusts_slip(g: GraspMemory) -> bool:
    """Return whether a slide of the object would be felt."""
    if g.trust.held > 0.0:
        return False
    longest = 0.0
    for i in range(int(g.belief.fingers)):
        longest = max(longest, g.trust.proof[i])
    return longest > 0.0


def counted_shift(g: GraspMemory, i: int, lag: float) -> float:
    """Return what finger ``i`` counts on above the lower bound of its friction, of ln mu.

    Felt slip that is not trusted lets no bound rise above that of the prior; ``lag`` is how many standard
    deviations are counted off the means.
    """
    if trusts_slip(g):
        return g.probe.shift[i]
    return g.probe.shift[i] + min(0.0, prior_bound(g, i, lag) - believed_bound(g, i, lag))


def prior_bound(g: GraspMemory, i: int, lag: float) -> float:
    """Return the lower bound of ln mu before anything was felt, at the present load."""
    load = g.belief.load[i]
    variance = g.trust.spread[i] * g.trust.spread[i] + load * load * g.trust.exponent_var
    return g.trust.prior[i] - g.trust.exponent * load - lag * math.sqrt(variance)


def believed_bound(g: GraspMemory, i: int, lag: float) -> float:
    """Return the lower bound of ln mu as it is believed."""
    return believed_mean(g, i) - lag * math.sqrt(believed_variance(g, i))


def counts_as_known(g: GraspMemory, i: int) -> bool:
    """Return whether finger ``i`` may count on more of its friction than one whose slip is not felt.

    Its slip is sensed, a slide of the object would be felt, and the object is not unknown any more: what is
    lifted has taught nothing yet.
    """
    known = believed_variance(g, i) <= g.probe.unknown * g.probe.unknown
    return known and is_heard(g, i) and trusts_slip(g)


def let_go(
    g: GraspMemory,
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
        g: what the grasp shares.
        i: the finger.
        dt: [s] since the last sample.
        lag: how many std are counted off the mean.
        asked: margin that it was asked to keep, what it was let go of counted in [-].
        u: utilisation at mu = 1; no farther ahead of it than ``TRUST_AHEAD``, lest a slide runs away.
        noise: std of the tangential force [N]; that must be large enough to show a slide.
        touching: whether it touches.
        slipping: whether it slips.

    """
    if not is_heard(g, i) or rise_of_slide(g, dt, noise) > TRUST_BLIND:
        g.probe.shift[i] = 0.0
    elif touching and not slipping and u > 0.0:
        if believed_bound(g, i, lag) + math.log(1.0 - asked) > math.log(u) + TRUST_AHEAD:
            return
        if trusts_slip(g):
            probe_friction(g, i, dt, lag)
        elif g.trust.held <= 0.0 and seeks_proof(g, i) and is_quiet(g, int(g.belief.fingers)):
            std, shift = math.sqrt(believed_variance(g, i)), g.probe.shift[i]
            most = math.inf  # of an object that is not known, it is not known either where it slides
            if std <= g.probe.unknown:
                low = min(prior_bound(g, i, lag), believed_bound(g, i, lag))
                most = believed_mean(g, i) + g.probe.reach * std - low
            g.probe.shift[i] = min(shift + TRUST_CLIMB * g.probe.climb * dt, max(most, shift))


def ends_probe(g: GraspMemory, i: int, dt: float, slipping: bool, sliding: bool) -> bool:
    """Return whether finger ``i`` slides by its flag, or for a while by its slip speed alone.

    The rim of a patch slides before all of it does, so the flag, which alone proves and teaches, comes later.
    """
    g.trust.rim[i] = g.trust.rim[i] + dt if sliding and not slipping else 0.0
    if slipping or g.trust.rim[i] > TRUST_FLAG_LATER + g.felt.delay:
        keep_nothing(g)
        return True
    return False


def seeks_proof(g: GraspMemory, i: int) -> bool:
    """Return whether finger ``i`` may be let go of to prove its channel.

    Where its slip speed shows noise it may with the others. Else one finger of three or more may, alone and
    beside the thumb, since the others hold what it gives up.
    """
    if g.trust.noisy[i] >= TRUST_LIVELY:
        return True
    n = int(g.belief.fingers)
    return n > 2 and i > 0 and whole_shift(g) <= g.probe.shift[i]


def follow_trust(
    g: GraspMemory,
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
        g: what the grasp shares.
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
    g.trust.proof[i] = max(g.trust.proof[i] - dt, 0.0)
    watch_constant(g, i, speed)
    void_lies(g, i)
    count_once(g, i)
    if not touching:
        g.trust.top[i] = g.trust.force[i] = g.trust.pull[i] = 0.0
    else:
        known = u if relative < ONSET_VAGUE else 0.0
        g.trust.false[i] *= math.exp(-dt / TRUST_FALSE_TIME)
        g.trust.told[i] += dt
        if (flag >= 0.5 or shows_sliding(g, speed)) and may_slide(g, i, known):
            g.trust.told[i] = 0.0
        if flag >= 0.5:
            hear_slide(g, i, known)
        g.trust.top[i] = max(known, g.trust.top[i] * math.exp(-dt / TRUST_TOP_TIME))
        if force > 0.0 and pull >= 0.0:
            part = 1.0 - math.exp(-dt / SMOOTHING) if g.trust.force[i] > 0.0 else 1.0
            g.trust.force[i] += part * (force - g.trust.force[i])
            g.trust.pull[i] += part * (pull - g.trust.pull[i])
    if g.probe.still[i] == 0.0:
        take_back(g)
    watch_slide(g, dt, noise)


def hear_slide(g: GraspMemory, i: int, u: float) -> None:
    """The flag of finger ``i`` tells slip at ``u``, 0 = not known: that proves it, or tells against it."""
    flag, top = i, g.trust.top[i]
    silent = g.felt.quiet[flag]
    is_expected = g.probe.shift[i] - g.trust.kept[i] > LEAST_PROBE and u >= TRUST_NEAR * top
    if is_expected and silent >= TRUST_SILENCE:
        g.trust.proof[i], g.trust.missed = TRUST_LASTS, 0.0
    if u > 0.0 and silent > 0.0 and not may_slide(g, i, u):
        g.trust.false[i] += 1.0
        if g.trust.false[i] > TRUST_FALSE_MOST:
            distrust(g, flag, FELT_BY_LOAD, FELT_DISTRUST)


def may_slide(g: GraspMemory, i: int, u: float) -> bool:
    """Return whether finger ``i`` may have slid at ``u``: not far below what has just held it."""
    return not u < TRUST_FAR * g.trust.top[i]


def is_constant(g: GraspMemory, i: int) -> bool:
    """Return whether the slip speed of finger ``i`` is exactly the same, or not sensed, for a while."""
    return g.trust.constant[i] > TRUST_STILL


def void_lies(g: GraspMemory, i: int) -> None:
    """Forget what the fingers have learned when the flag of finger ``i`` has just been found to be wrong.

    Friction that was low before any flag lied is expected to be no more than a standard deviation higher.
    """
    flag = i
    is_off = g.felt.off[flag] > 0.0
    silent = math.inf
    for j in range(int(g.belief.fingers)):
        silent = min(silent, g.felt.quiet[j])
    if silent >= TRUST_CLEAN_TIME:
        g.trust.clean[i] = g.belief.mean[i]
    if is_off and g.trust.void[i] == 0.0 and g.felt.why[flag] != FELT_DEAF:
        g.trust.proof[i] = 0.0
        for j in range(int(g.belief.fingers)):
            forget_evidence(g, j, min(g.trust.prior[j], g.trust.clean[j] + g.trust.spread[j]))
    g.trust.void[i] = 1.0 if is_off else 0.0


def watch_constant(g: GraspMemory, i: int, speed: float) -> None:
    """Void the proof of finger ``i`` where its slip speed, which was noisy, is a constant now, or is gone."""
    if speed == g.trust.speed[i] or math.isnan(speed):
        g.trust.constant[i] += 1.0
        if is_constant(g, i) and g.trust.noisy[i] >= TRUST_LIVELY:
            g.trust.noisy[i] = g.trust.proof[i] = 0.0
            take_back(g)
    else:
        g.trust.noisy[i] = min(g.trust.noisy[i] + 1.0, TRUST_LIVELY)
        g.trust.speed[i], g.trust.constant[i] = speed, 0.0


def whole_shift(g: GraspMemory) -> float:
    """Return by how much all fingers together are let go of, of ln mu."""
    total = 0.0
    for i in range(int(g.belief.fingers)):
        total += g.probe.shift[i]
    return total


def whole_load(g: GraspMemory) -> tuple[float, float]:
    """Return the normal and the tangential force [N] of all fingers together."""
    force, pull = 0.0, 0.0
    for i in range(int(g.belief.fingers)):
        force += g.trust.force[i]
        pull += g.trust.pull[i]
    return force, pull


def rise_of_slide(g: GraspMemory, dt: float, noise: float) -> float:
    """Return the rise of y that noise does not make; ``dt`` [s] is from sample to sample of one finger."""
    _, pull = whole_load(g)
    if not (pull > 0.0 and dt > 0.0):
        return math.inf
    std = noise * math.sqrt(g.belief.fingers * dt / (dt + 2.0 * SMOOTHING))
    return max(TRUST_RISE, TRUST_NOISE * std / pull)


def watch_slide(g: GraspMemory, dt: float, noise: float) -> None:
    """Look whether the load shows a slide, and judge the last one that it has shown."""
    part = dt / g.belief.fingers
    g.trust.held = max(g.trust.held - part, 0.0)
    force, pull = whole_load(g)
    if g.trust.wait > 0.0 and holds_after_all(g, pull, force):
        g.trust.wait = 0.0
    if g.trust.wait > 0.0:
        g.trust.wait -= part
        if g.trust.grip > 0.0 and force >= TRUST_MORE * g.trust.grip:
            g.trust.grip, g.trust.wait = 0.0, min(g.trust.wait, TRUST_SEEN + g.felt.delay)
        is_back = pull >= g.trust.load - (1.0 - TRUST_BACK) * g.trust.fell
        if g.trust.wait <= 0.0 and g.trust.grip == 0.0 and is_back:
            judge_slide(g)
        return
    kept = 0.0
    for i in range(int(g.belief.fingers)):
        kept += g.trust.kept[i]
    let = whole_shift(g) - kept
    if not (let > LEAST_PROBE and force > 0.0 and pull > 0.0):
        g.trust.least = math.inf
        g.trust.first = g.trust.later = max(force, 0.0)
        g.trust.ratio = 0.0
        return
    if has_torn(g, pull, force, part, rise_of_slide(g, dt, noise)):
        g.trust.ratio, g.trust.least = 0.0, math.inf
        take_back(g)
        await_slip(g, pull, force)
        return
    if is_slow(g, force, part):
        keep_held(g)
        take_back(g)
        g.probe.since_slip = 0.0
        return
    y = TRUST_SHARE * math.log(force) - math.log(pull)
    forgotten = 1.0 - math.exp(-part / TRUST_FORGET)
    if y > g.trust.least and y - g.trust.least > rise_of_slide(g, dt, noise):
        if math.log(g.trust.grip / force) >= TRUST_ALIKE * math.log(g.trust.load / pull):
            keep_nothing(g)
            take_back(g)
            g.probe.since_slip, g.trust.least = 0.0, math.inf
            if math.log(g.trust.grip / force) <= TRUST_FADING * math.log(g.trust.load / pull):
                g.trust.held = TRUST_HOLD
                await_slip(g, pull, force)
            return
        forgotten = 1.0
    if y <= g.trust.least:
        forgotten = 1.0
        g.trust.least = y
    g.trust.least += forgotten * (y - g.trust.least)
    g.trust.load += forgotten * (pull - g.trust.load)
    g.trust.grip += forgotten * (force - g.trust.grip)


def await_slip(g: GraspMemory, pull: float, force: float) -> None:
    """Wait for a channel to tell the slide in which f has fallen to ``pull`` [N] at N = ``force`` [N]."""
    g.trust.wait, g.trust.fell = TRUST_JUDGED + g.felt.delay, g.trust.load - pull
    g.trust.torn = pull / force


def holds_after_all(g: GraspMemory, pull: float, force: float) -> bool:
    """Return whether f, ``pull`` [N] now, was a load that changed and no slide: then f / N would be friction.

    It has risen again, or is far below friction before N is back.
    """
    ratio = pull / force if force > 0.0 else 0.0
    is_back = ratio > g.trust.torn * (1.0 + TRUST_BACK * g.trust.fell / g.trust.load)
    is_gone = ratio < TRUST_FAR * g.trust.torn and force < TRUST_MORE * g.trust.grip
    return is_back or is_gone


def is_slow(g: GraspMemory, force: float, dt: float) -> bool:
    """Return whether N, ``force`` [N] now, falls so slowly that its fall would not show a slide in time."""
    g.trust.later += (1.0 - math.exp(-dt / TRUST_LATER_TIME)) * (force - g.trust.later)
    rate = math.log(g.trust.later / force) / TRUST_LATER_TIME
    return force < TRUST_BEGUN * g.trust.first and rate < TRUST_SLOW


def has_torn(g: GraspMemory, pull: float, force: float, dt: float, rise: float) -> bool:
    """Return whether f, ``pull`` [N] now, has fallen at once, and more than N, as when a slide begins."""
    ratio = pull / force
    lagging = g.trust.ratio + (1.0 - math.exp(-dt / TRUST_TORN_TIME)) * (ratio - g.trust.ratio)
    g.trust.ratio = max(ratio, lagging)
    least = math.exp(-rise)
    return ratio < least * g.trust.ratio and pull < least * g.trust.load


def take_back(g: GraspMemory) -> None:
    """Take back at once what all fingers were let go of, down to what the load has shown to hold."""
    if not trusts_slip(g):
        keep_nothing(g)
    for i in range(int(g.belief.fingers)):
        g.probe.shift[i] = min(g.probe.shift[i], g.trust.kept[i])


def count_once(g: GraspMemory, i: int) -> None:
    """Let go of finger ``i`` by so much less as its belief has risen: a load that held counts once."""
    rise = max(g.belief.mean[i] - g.trust.mean[i], 0.0)
    g.trust.mean[i] = g.belief.mean[i]
    g.probe.shift[i] = max(g.probe.shift[i] - rise, 0.0)
    g.trust.kept[i] = max(g.trust.kept[i] - rise, 0.0)


def keep_held(g: GraspMemory) -> None:
    """Note that N has fallen quickly and no slide was seen: the contacts hold with little more than that."""
    for i in range(int(g.belief.fingers)):
        g.trust.kept[i] = max(g.probe.shift[i] - TRUST_RETREAT, g.trust.kept[i])


def keep_nothing(g: GraspMemory) -> None:
    """Forget with what the contacts have held."""
    for i in range(BELIEF_MOST):
        g.trust.kept[i] = 0.0


def judge_slide(g: GraspMemory) -> None:
    """Decide whether the object slid and no channel told it."""
    g.trust.wait = 0.0
    n = int(g.belief.fingers)
    silent = math.inf
    for i in range(n):
        silent = min(silent, g.trust.told[i])
    heard = silent < TRUST_JUDGED + g.felt.delay + TRUST_BEFORE
    if heard:
        return
    g.trust.missed += 1.0
    lasts = TRUST_DEAF if g.trust.missed < 2.0 else TRUST_DEAD
    for i in range(n):
        g.trust.proof[i] = 0.0
        distrust(g, i, FELT_DEAF, lasts)
        distrust(g, BELIEF_MOST + i, FELT_DEAF, lasts)
