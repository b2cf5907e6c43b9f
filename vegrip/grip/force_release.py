"""Friction that a finger assumes, and how force is lowered to learn it: decisions by expected loss.

**Assumed.** Let P be the probability that a slide would be noticed in time, as far as it was shown, F the
distribution of ln mu as it is believed, and F_c that of friction that has changed, wider by ``CHANGE_STD``. A
slide that is not noticed loses the object, and nor would be noticed that friction has changed; one that is
noticed costs kappa of that, the more the later the drive answers. So x is assumed with::

    (1 - P) ((1 - RARE) F(x) + RARE F_c(x)) + P kappa F(x) = risk

What is believed without a channel comes from loads that held: a load never exceeds friction, whether the
object holds or slides, so it teaches though no channel would notice a slide.

**Lowered.** A finger that is asked to keep the margin m assumes ``x + b``, b >= 0. At the utilisation u
with ``z = (ln u - m_b) / s_b`` a finger that has held slides with the chance ``phi(z) / (s_b (1 - Phi(z)))``
for each unit by which ln u rises, one over Mills' ratio and s_b. So with::

    db/dt = rate s_b (1 - Phi(z)) / phi(z),       rate = (e^(m_b - x) - 1 - WORTH) / (n COST)

slides of n fingers come at this rate: it is the part of the force that is held for want of knowledge, over
what one slide costs. Where no channel is proven, the load alone is a witness (:mod:`.slip_witness`), which
sees a slide the sooner, the faster N falls: then b grows by ``QUICK``.

b returns to 0 when a finger slides, which teaches, and when a load changes; what has held until then is
evidence that friction is higher. Where no channel is proven it is none if T has fallen with N: that may be a
slide.

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.estimator.normal_law import inverse_mills, upper_tail
from vegrip.grip.drive_lag import expected_lag
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.grip.slip_witness import *


def set_risk(g: GraspMemory, risk: float, noticed_risk: float, releases: bool) -> None:
    """Set the risks of a slide that is not noticed and of one that is, and whether force is lowered."""
    g.release.releases = 1.0 if releases else 0.0
    g.release.risk, g.release.kappa = risk, risk / noticed_risk


def begin_release(g: GraspMemory) -> None:
    """Have lowered nothing."""
    for i in range(BELIEF_MOST):
        g.release.still[i], g.release.counted[i] = -1.0, math.nan


def chance_noticed(g: GraspMemory) -> float:
    """Return P, 0 where force is not lowered at all."""
    return noticed(g) if g.release.releases > 0.0 else 0.0


def shown_noticed(g: GraspMemory) -> float:
    """Return P as far as it was shown: 0 for channels of which nothing is known, P where one is proven."""
    p = chance_noticed(g)
    return min(p, max(p - USUAL, 0.0) * SURE / (SURE - USUAL))


def reacts(g: GraspMemory, i: int) -> bool:
    """Return whether the grip must grow because finger ``i`` slides.

    A slide that the lowering caused ends with that, and is reported for a while longer.
    """
    return g.slip.slides[i] >= EVEN and g.release.ends <= 0.0


def cost_of_noticed(g: GraspMemory) -> float:
    """Return what a slide that is noticed costs, of one that loses the object.

    Until the drive has answered, the object goes on by a distance that grows with the square of the time.
    """
    part = (g.slip.delay + LOOK + slowest_drive(g)) / ANSWERED
    return min(g.release.kappa * part * part, 1.0)


def counted_on(g: GraspMemory, i: int) -> float:
    """Return the ln mu of finger ``i`` that is assumed, by halving."""
    p = shown_noticed(g)
    mean, std = believed_mean(g, i), math.sqrt(believed_variance(g, i) + NEARLY_NONE)
    wider = math.hypot(std, CHANGE_STD)
    kappa = cost_of_noticed(g)
    low, high = mean - 4.0 * wider, mean
    for _ in range(16):
        x = 0.5 * (low + high)
        believed = upper_tail((mean - x) / std)
        changed = (1.0 - RARE) * believed + RARE * upper_tail((mean - x) / wider)
        loss = (1.0 - p) * changed + p * kappa * believed
        if loss < g.release.risk:
            low = x
        else:
            high = x
    return 0.5 * (low + high)


def watch_quiet(g: GraspMemory, i: int, dt: float, load: float, noise: float, touching: bool) -> bool:
    """Follow the load [N] of finger ``i``, of noise ``noise`` [N]; return whether it has changed."""
    if not (touching and load >= 0.0):
        g.release.still[i] = -1.0
        g.release.shift[i] = 0.0
        return False
    if g.release.still[i] < 0.0:
        g.release.smooth[i] = g.release.steady[i] = load
        g.release.still[i] = 0.0
    g.release.smooth[i] += (1.0 - math.exp(-dt / LOOK)) * (load - g.release.smooth[i])
    g.release.still[i] += dt
    g.release.steady[i] += (1.0 - math.exp(-dt / PAUSE)) * (g.release.smooth[i] - g.release.steady[i])
    change = abs(g.release.smooth[i] - g.release.steady[i])
    if change <= QUIET_CHANGE * g.release.steady[i] + 2.0 * noise:
        return False
    g.release.steady[i], g.release.still[i] = g.release.smooth[i], 0.0
    return True


def is_quiet(g: GraspMemory, n: int) -> bool:
    """Return whether no finger has slid and no load has changed for a while."""
    for j in range(n):
        if 0.0 <= g.release.still[j] < RETURN:
            return False
    return g.release.pause <= 0.0


def take_back(g: GraspMemory, held: bool) -> None:
    """Restore what was lowered; where the object has surely ``held`` that shows that friction is higher.

    A load that would need more than ``CREDIBLE`` standard deviations above the mean may be wrong.
    """
    for i in range(int(g.belief.fingers)):
        is_told = g.witness.slid[i] <= 0.0 or sound_channel(g, i) >= SURE
        if g.release.shift[i] > RISE and held and is_told:
            ln_u = g.slip.shown[i] - g.slip.exponent * g.belief.load[i]
            off = ln_u - believed_mean(g, i)
            if abs(off) < CREDIBLE * math.sqrt(believed_variance(g, i)):
                absorb_hold(g, i, ln_u, SCATTER * SCATTER)
        g.release.shift[i] = 0.0


def let_go(g: GraspMemory, i: int, dt: float, margin: float, touching: bool) -> None:
    """Let go of finger ``i``, which is asked to keep this ``margin`` [-], for another ``dt`` [s]."""
    n, p = int(g.belief.fingers), chance_noticed(g)
    if not (touching and g.slip.level[i] > -math.inf and is_quiet(g, n) and is_watched(g)):
        return
    ln_u = g.slip.level[i] - g.slip.exponent * g.belief.load[i]
    mean, std = believed_mean(g, i), math.sqrt(believed_variance(g, i) + NEARLY_NONE)
    counted = g.release.counted[i]
    most, rate = math.inf, QUICK
    if p >= SURE:
        z = max((ln_u - mean) / std, -OUTLIER)
        worth = max(math.exp(mean - counted) - 1.0 - WORTH, 0.0)
        most = mean + CREDIBLE * std
        rate = min(worth / (COST * g.belief.fingers) * std / inverse_mills(-z), QUICK)
    elif rise_needed(g, dt) + QUICK * slowest_drive(g) > BLIND:
        return
    most = min(most, ln_u + rate * LEAD) - math.log(1.0 - margin) - counted
    g.release.shift[i] = max(g.release.shift[i], min(g.release.shift[i] + rate * dt, most))


def is_watched(g: GraspMemory) -> bool:
    """Return whether a channel may tell of a slide: a proven one, or one beside which no other is unsound."""
    p = chance_noticed(g)
    return p >= SURE or (p >= USUAL - RARE and not has_unsound(g))


def slowest_drive(g: GraspMemory) -> float:
    """Return the longest lag of the drives [s]: so long N goes on falling after a slide is seen."""
    slowest = 0.0
    for i in range(int(g.belief.fingers)):
        slowest = max(slowest, expected_lag(g, i))
    return slowest


def stated_std(std: float) -> float:
    """Return the std of ln mu that is stated: friction may have changed since it was felt."""
    return math.sqrt(std * std + SCATTER * SCATTER)


def note_slide(g: GraspMemory, i: int, unsure: float) -> None:
    """Learn from a slide of finger ``i``; at its end the next one is another."""
    teacher = int(g.slip.teacher[i])
    if g.belief.doubted[i] > 0.0:
        if g.slip.silence[teacher] >= PAUSE and g.slip.sound[teacher] >= SURE:
            g.belief.doubted[i] = 0.0
        elif is_unsound(g, teacher):
            void_slides(g)
    if g.slip.slides[i] < SURE:
        if g.slip.slides[i] < UNSURE:
            g.slip.taught[i] = 0.0
        return
    if g.slip.taught[i] > 0.0 or not (unsure <= SCATTER and g.slip.top[i] > -math.inf):
        return
    g.slip.taught[i], g.slip.held[i], g.slip.teacher[i] = 1.0, g.slip.top[i], float(teller(g, i))
    ln_u = g.slip.top[i] - g.slip.exponent * g.belief.load[i]
    absorb_slide(g, i, ln_u, SCATTER * SCATTER + unsure * unsure)


def ends_slowly(g: GraspMemory, dt: float) -> bool:
    """Return whether N falls too slowly for the load to be a witness."""
    n, force = int(g.belief.fingers), 0.0
    for i in range(n):
        force += g.witness.forces[i]
    return force > 0.0 and g.witness.first > 0.0 and is_slow(g, dt / float(n), force)


def decide(g: GraspMemory, i: int, dt: float, margin: float, touching: bool, changed: bool) -> None:
    """Go on with what finger ``i`` assumes, after one sample of it."""
    n = int(g.belief.fingers)
    total = 0.0
    for j in range(n):
        total += g.release.shift[j]
    g.release.pause = max(g.release.pause - dt / float(n), 0.0)
    g.release.ends = max(g.release.ends - dt / float(n), 0.0)
    watch_part(g, i, dt, total)
    if g.slip.slides[i] >= EVEN or sees_slide(g, dt, total, changed and chance_noticed(g) < SURE):
        if total > SCATTER:
            g.release.ends = 2.0 * (g.slip.delay + LOOK)
        take_back(g, False)
        g.release.pause = PAUSE
    elif total > 0.0 and not is_watched(g):
        take_back(g, False)
        g.release.pause = PAUSE
    elif changed or (total > 0.0 and chance_noticed(g) < SURE and ends_slowly(g, dt)):
        take_back(g, chance_noticed(g) >= SURE or g.witness.waits <= 0.0)
        g.release.pause = 0.0 if changed else PAUSE
    g.release.counted[i] = counted_on(g, i)
    let_go(g, i, dt, margin, touching)
