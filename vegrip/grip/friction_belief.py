"""What is believed of the friction between one object and the fingers that hold it, as one joint Gaussian.

Over ``z = (x_1 .. x_n, g)``: ``x_i = ln mu_i`` at the reference load, and the exponent by which the friction
of all falls with the load (:mod:`vegrip.estimator.kernels.load_law`). At its relative load ``l_i = ln(N_i /
N_0)`` finger i has ``ln mu_i(N_i) = x_i - g l_i = h' z``. All fingers touch one object, so most of what is
not known is common::

    x ~ N(mean, common^2 11' + own^2 I),    g ~ N(exponent, s_g^2)    before anything is felt

Evidence about one finger is a Gaussian factor on ``h' z``: its precision p and its mean m. With ``P h = s``::

    mean <- mean + s p (m - h' mean) / (1 + p h' s),      P <- P - s s' p / (1 + p h' s) .

* **A slide** measures ``h' z`` by ln u. One slide counts for no more than one at five standard deviations,
  and one of a light touch, which tells friction to worse than 0.1 in ln mu, for nothing.
* **A load that held** says ``h' z > ln u``: its factor has the first two moments of the truncated Gaussian.
  There is one such factor for each finger, of the most that it has held since it last slid: more of the same
  shows nothing new, and a thousand looks at one load are one piece of evidence.
* **Forgetting** widens P with time, most of it for all fingers alike, never beyond the prior.
* **Friction may have changed** for all fingers alike (the faces got wet): two hypotheses, of which a slide
  that is off by d makes the second one more likely. With its probability the common variance is widened
  first::

      p = RARE N(d; S + CHANGE_STD^2) / (RARE N(d; S + CHANGE_STD^2) + (1 - RARE) N(d; S)),   S = h'Ph +
      noise

Plain scalar code over :class:`~vegrip.grip.grasp_memory.GraspMemory`; the same text is compiled.
"""

import math

from vegrip.estimator.normal_law import inverse_mills
from vegrip.grip.friction_numbers import *
from vegrip.grip.grasp_memory import BELIEF_MOST, BELIEF_ROW, GraspMemory


def begin_belief(g: GraspMemory, fingers: int, drift: float) -> None:
    """Begin, in a memory of zeros, with fingers of which nothing is expected yet: :func:`expect_finger`."""
    g.belief.fingers, g.belief.drift = fingers * 1.0, drift
    for i in range(BELIEF_MOST):
        g.belief.record[i] = -math.inf


def expect_exponent(g: GraspMemory, mean: float, variance: float) -> None:
    """Set the prior of the exponent by which friction falls with the load; before, friction is constant."""
    n = int(g.belief.fingers)
    g.belief.mean[n], g.belief.p[n * BELIEF_ROW + n] = mean, variance
    g.belief.exponent_var = variance


def expect_finger(g: GraspMemory, i: int, mean: float, std: float, own: float) -> None:
    """Set the prior of finger ``i``: ``mean`` and ``std`` of ln mu, of which ``own`` is not common to all."""
    g.belief.mean[i] = mean
    g.belief.common[i] = math.sqrt(max(std * std - own * own, 0.0))
    g.belief.prior_var = max(g.belief.prior_var, std * std)
    set_common(g, i)
    g.belief.p[i * BELIEF_ROW + i] = std * std


def set_common(g: GraspMemory, i: int) -> None:
    """Let finger ``i`` share with the others what was common at first, and nothing with the exponent."""
    n = int(g.belief.fingers)
    for j in range(n):
        shared = g.belief.common[i] * g.belief.common[j]
        g.belief.p[i * BELIEF_ROW + j] = g.belief.p[j * BELIEF_ROW + i] = shared
    g.belief.p[i * BELIEF_ROW + n] = g.belief.p[n * BELIEF_ROW + i] = 0.0


def believed_mean(g: GraspMemory, i: int) -> float:
    """Return the mean of ln mu of finger ``i`` at its present load."""
    return g.belief.mean[i] - g.belief.mean[int(g.belief.fingers)] * g.belief.load[i]


def believed_variance(g: GraspMemory, i: int) -> float:
    """Return the variance of ln mu of finger ``i`` at its present load."""
    load = g.belief.load[i]
    return shared_part_of(g, i, i, load) - load * shared_part_of(g, int(g.belief.fingers), i, load)


def shared_part_of(g: GraspMemory, j: int, i: int, load: float) -> float:
    """Return the covariance of number ``j`` of z with ln mu of finger ``i`` at a relative ``load``."""
    return g.belief.p[j * BELIEF_ROW + i] - load * g.belief.p[j * BELIEF_ROW + int(g.belief.fingers)]


def widen_belief(g: GraspMemory) -> None:
    """Forget what the time since the last look asks for, never beyond the prior."""
    g.belief.version += 1.0
    if not is_doubted(g):
        average_belief(g, g.belief.since)
    grown = g.belief.drift * g.belief.drift * g.belief.since
    g.belief.since = 0.0
    add_common(g, COMMON * grown)
    for i in range(int(g.belief.fingers)):
        if g.belief.p[i * BELIEF_ROW + i] > 0.0:
            add_own(g, i, (1.0 - COMMON) * grown)


def average_belief(g: GraspMemory, dt: float) -> None:
    """Go on with what is believed of a finger at any time of the grasp, after ``dt`` [s] more of it.

    Mean and variance of a mixture over time and fingers: a face that is wet for a while counts for so long.
    """
    n, mean, square, pressing = int(g.belief.fingers), 0.0, 0.0, 0.0
    for i in range(n):
        mean += g.belief.mean[i] / g.belief.fingers
        square += (g.belief.mean[i] * g.belief.mean[i] + g.belief.p[i * BELIEF_ROW + i]) / g.belief.fingers
        pressing += g.witness.forces[i]
    if pressing > 0.0 and dt > 0.0:
        g.belief.lasted += dt
        g.belief.usual += dt / g.belief.lasted * (mean - g.belief.usual)
        g.belief.usual_square += dt / g.belief.lasted * (square - g.belief.usual_square)


def add_common(g: GraspMemory, grown: float) -> None:
    """Add a variance that all fingers share, as far as the widest of them stays below the prior.

    Friction that is stated and not learned has none, and stays so.
    """
    n = int(g.belief.fingers)
    widest = 0.0
    for i in range(n):
        widest = max(widest, g.belief.p[i * BELIEF_ROW + i])
    room = min(grown, max(g.belief.prior_var - widest, 0.0))
    for i in range(n):
        for j in range(n):
            if g.belief.p[i * BELIEF_ROW + i] > 0.0 and g.belief.p[j * BELIEF_ROW + j] > 0.0:
                g.belief.p[i * BELIEF_ROW + j] += room


def widen_own(g: GraspMemory, i: int, grown: float) -> None:
    """Forget what finger ``i`` has for itself by this variance: it has let go and touched again."""
    add_own(g, i, grown)
    g.belief.version += 1.0


def add_own(g: GraspMemory, i: int, grown: float) -> None:
    """Add a variance to finger ``i`` alone, as far as the prior."""
    at = i * BELIEF_ROW + i
    g.belief.p[at] = max(g.belief.p[at], min(g.belief.p[at] + grown, g.belief.prior_var))


def absorb_factor(g: GraspMemory, i: int, load: float, precision: float, weighted: float) -> None:
    """Multiply by a Gaussian factor on ln mu of finger ``i`` at a relative ``load``.

    A factor is its precision, and that times its mean. One that would leave no variance (a negative precision
    larger than what is known) is ignored.
    """
    n = int(g.belief.fingers)
    for j in range(n + 1):
        g.belief.along[j] = shared_part_of(g, j, i, load)
    left = 1.0 + precision * (g.belief.along[i] - load * g.belief.along[n])
    if not (left > NEARLY_NONE and abs(weighted) < math.inf):
        return
    off = (weighted - precision * (g.belief.mean[i] - load * g.belief.mean[n])) / left
    shrink = precision / left
    for j in range(n + 1):
        g.belief.mean[j] += g.belief.along[j] * off
        for k in range(n + 1):
            g.belief.p[j * BELIEF_ROW + k] -= shrink * g.belief.along[j] * g.belief.along[k]
    g.belief.version += 1.0


def remove_factor(g: GraspMemory, i: int, load: float, precision: float, weighted: float) -> None:
    """Take a factor off again, as far as no more is left open than at first: some of it has been forgotten.

    One that is nearly all that is known stays: rounding would be what is left.
    """
    variance = shared_part_of(g, i, i, load) - load * shared_part_of(g, int(g.belief.fingers), i, load)
    first = g.belief.prior_var + load * load * g.belief.exponent_var
    if precision > 0.0 and 0.0 < variance < first:
        part = min(1.0, (1.0 / variance - 1.0 / first) / precision)
        if part * precision * variance < SURE:
            absorb_factor(g, i, load, -part * precision, -part * weighted)


def remove_hold(g: GraspMemory, i: int) -> None:
    """Take off what loads that held have said of finger ``i``."""
    remove_factor(g, i, g.belief.site_load[i], g.belief.site[i], g.belief.site_weighted[i])
    g.belief.site[i], g.belief.record[i] = 0.0, -math.inf


def refuse_evidence(g: GraspMemory) -> None:
    """Learn nothing of what a finger's own estimate has learned; it is told again what the grasp believes."""
    g.belief.version += 1.0


def absorb_slide(g: GraspMemory, i: int, ln_u: float, noise: float) -> None:
    """Take in that finger ``i`` slid at ``ln_u``, known with the variance ``noise``, at its present load."""
    widen_belief(g)
    if not is_doubted(g):
        keep_safe(g)
    g.belief.doubted[i] = 1.0
    remove_hold(g, i)
    off, expected = ln_u - believed_mean(g, i), believed_variance(g, i) + noise
    changed = chance_of_change(off, expected)
    add_common(g, CHANGE_STD * CHANGE_STD * changed)
    if changed >= EVEN:
        forget_holds(g)
    most = OUTLIER * math.sqrt(believed_variance(g, i) + noise)
    counted = believed_mean(g, i) + min(max(off, -most), most)
    absorb_factor(g, i, g.belief.load[i], 1.0 / noise, counted / noise)


def is_doubted(g: GraspMemory) -> bool:
    """Return whether what some slide has said may be a lie."""
    for i in range(int(g.belief.fingers)):  # noqa: SIM110 (compiled)
        if g.belief.doubted[i] > 0.0:
            return True
    return False


def keep_safe(g: GraspMemory) -> None:
    """Keep what is believed now, before a slide that may be a lie."""
    for j in range(BELIEF_ROW):
        g.belief.safe_mean[j] = g.belief.mean[j]
    for j in range(BELIEF_ROW * BELIEF_ROW):
        g.belief.safe_p[j] = g.belief.p[j]
    for i in range(BELIEF_MOST):
        g.belief.safe_record[i], g.belief.safe_site[i] = g.belief.record[i], g.belief.site[i]
        g.belief.safe_weighted[i], g.belief.safe_load[i] = g.belief.site_weighted[i], g.belief.site_load[i]


def void_slides(g: GraspMemory) -> None:
    """Return to what was believed before the first slide in doubt: a channel that has told one is unsound.

    What was held is referred by the exponent of then: to that of now, as all that is seen of utilisations.
    """
    if not is_doubted(g):
        return
    n = int(g.belief.fingers)
    moved = g.slip.exponent - g.belief.safe_mean[n]
    for j in range(BELIEF_ROW):
        g.belief.mean[j] = g.belief.safe_mean[j]
    for j in range(BELIEF_ROW * BELIEF_ROW):
        g.belief.p[j] = g.belief.safe_p[j]
    for i in range(BELIEF_MOST):
        g.belief.record[i] = g.belief.safe_record[i] + moved * g.belief.safe_load[i]
        g.belief.site[i], g.belief.site_weighted[i] = g.belief.safe_site[i], g.belief.safe_weighted[i]
        g.belief.site_load[i] = g.belief.safe_load[i]
    clear_doubts(g)
    g.belief.version += 1.0


def clear_doubts(g: GraspMemory) -> None:
    """Doubt no slide any more: what is believed now stays."""
    for i in range(BELIEF_MOST):
        g.belief.doubted[i] = 0.0


def forget_holds(g: GraspMemory) -> None:
    """Let what fingers hold from now on count anew: friction is another than what they have held shows."""
    for i in range(BELIEF_MOST):
        g.belief.site[i], g.belief.record[i] = 0.0, -math.inf


def chance_of_change(off: float, expected: float) -> float:
    """Return the probability that friction has changed, by a slide that is off by so much of ln mu.

    ``expected`` is the variance that it should have.
    """
    wider = expected + CHANGE_STD * CHANGE_STD
    ratio = 0.5 * off * off * (1.0 / expected - 1.0 / wider) + 0.5 * math.log(expected / wider)
    return 1.0 / (1.0 + (1.0 - RARE) / RARE * math.exp(-min(ratio, 50.0)))


def absorb_hold(g: GraspMemory, i: int, ln_u: float, noise: float) -> None:
    """Take in that finger ``i`` held at ``ln_u``, known with the variance ``noise``, at its present load.

    With ``q = (h' mean - ln u) / sqrt(h' P h + noise)`` and ``r = phi(q) / Phi(q)``, the mean of
    ``h' z`` rises by ``h' P h r / sqrt(..)`` and its variance falls by ``(h' P h)^2 r (q + r) / (..)``.
    """
    record = ln_u + g.belief.mean[int(g.belief.fingers)] * g.belief.load[i]
    if not record > g.belief.record[i] + RISE:
        refuse_evidence(g)
        return
    widen_belief(g)
    remove_hold(g, i)
    g.belief.record[i] = record
    mean, variance = believed_mean(g, i), believed_variance(g, i)
    spread = math.sqrt(variance + noise)
    q = (mean - ln_u) / spread
    ratio = inverse_mills(q)
    left = 1.0 - variance * ratio * (q + ratio) / (spread * spread)
    if not (variance > 0.0 and left > NEARLY_NONE):
        return
    precision = (1.0 / left - 1.0) / variance
    after = mean + variance * ratio / spread
    weighted = (1.0 / left) * after / variance - mean / variance
    absorb_factor(g, i, g.belief.load[i], precision, weighted)
    g.belief.site[i], g.belief.site_weighted[i], g.belief.site_load[i] = precision, weighted, g.belief.load[i]
