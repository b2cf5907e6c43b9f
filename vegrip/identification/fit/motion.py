"""The motion behind a noisy displacement: what moved smoothly, where it jerked, and how well that is known.

Two quantities, position and speed, straight within a step and bent at the samples by an acceleration,

    ``d+ = d + v dt``,   ``v+ = v + a dt``,   ``a ~ N(0, q)``,   ``measured = d + e``

(an acceleration that lasts through the step would leave a jump ringing for ever: it has a zero at half of
the sampling rate) with a variance q of its own for every step, found by maximum likelihood as in
[Tipping2001]_: where the drive ramps or rests q goes to zero and the noise is averaged away, where it starts
or stops q grows and nothing is rounded off. Where a straight line is as good (:func:`straight`) no jerk is
looked for: the largest of thousands of errors looks like one, and a law that remembers its way (friction,
wear) adds up every such step.

Why: a candidate that follows the displacement late (lag, backlash) averages the noise of the motion away
and would so explain a recording better that has neither. Behind a smoothed motion there is no such noise.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.types import Floats

HALVES = (8, 16, 32, 64, 128, 256, 512, 1024)  # samples on each side of the instant
MAX_HINGE_STD = 4.0  # standard errors of the hinge; chance alone gets there in one window of 16 000
LINE, CUBIC = 1, 3  # degrees
CURVED = 9.0  # of two squared standard normal numbers; chance alone gets there in one run of 90
PRIOR_VARIANCE = 1e6  # noise variances: what is known of the position before the first sample
MOTION_ROUNDS = 20
# steps that share a variance of the acceleration; one alone takes single errors for jerks
ACCELERATION_STEPS = 5
REST_STEP = 5e-3  # accelerations that move less than this many standard deviations in a step are rest, and
STRAIGHT_SHARE = 1e-4  # what is allowed where the motion is straight to within the noise


def straight(t: Floats, first: Floats, measured: Floats, noise: float) -> NDArray[np.bool_]:
    """Return for every sample (n,) whether ``measured`` [m] runs straight around it, to within the ``noise``.

    The test is a hinge. Through the samples on both sides of an instant goes a line that may bend there,

        ``y = a + b u + c |u| + e``,   ``u = t - t_i``,   ``e ~ N(0, noise^2)``,

    and ``c`` over its standard error is a standard normal number where nothing bends. The windows double from
    8 samples on each side to 1024: a jerk shows in the short ones, a slow creep in the long ones. Of a bend
    only the shortest window that sees it counts; a longer one that contains such a window says nothing. What
    is left between two bends may be too short for the windows that would see its own: there, square and cube
    of time are tested over the whole run.

    ``first`` is 1 where an episode begins; ``measured`` is NaN where missing. The first and last samples of
    an episode count as their neighbours within.
    """
    bent = np.zeros(t.size, dtype=np.bool_)
    for half in HALVES:
        bent |= _bends(t, first, measured, noise, half, MAX_HINGE_STD, bent)
    for low, high in _runs(~bent, first):
        bent[low:high] = _curvature(t[low:high], measured[low:high]) > CURVED * noise**2
    return ~bent


def _runs(wanted: NDArray[np.bool_], first: Floats) -> list[tuple[int, int]]:
    episode = np.cumsum(first > 0.0)
    at = np.flatnonzero(np.diff(np.where(wanted, episode, -1), prepend=-1, append=-1))
    return [(low, high) for low, high in pairwise(at.tolist()) if wanted[low] and high - low > CUBIC + 1]


def _curvature(t: Floats, measured: Floats) -> float:
    """Return how much the sum of squares [m^2] falls when square and cube of time are fitted to a run too."""
    known = ~np.isnan(measured)
    if np.count_nonzero(known) <= CUBIC:
        return 0.0
    u = np.interp(t[known], [t[0], t[-1]], [-1.0, 1.0])
    powers, _ = np.linalg.qr(np.vander(u, CUBIC + 1, increasing=True))
    return float(np.sum((powers[:, LINE + 1 :].T @ (measured[known] - measured[known][0])) ** 2))


@njit
def _bends(
    t: Floats, first: Floats, measured: Floats, noise: float, half: int, bent: float, known: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return the samples (n,) within a window of ``half`` that bends and holds none that is ``known`` to."""
    n = t.shape[0]
    out = np.zeros(n, dtype=np.bool_)
    bends_before = np.zeros(n + 1)  # how many known bends, and how many beginnings, come before a sample
    begun_before = np.zeros(n + 1)
    for i in range(n):
        bends_before[i + 1] = bends_before[i] + known[i]
        begun_before[i + 1] = begun_before[i] + (first[i] > 0.0)
    step = max(half // 8, 1)
    for i in range(half, n - half, step):
        low, high = i - half, i + half + 1
        if begun_before[high] > begun_before[low + 1] or bends_before[high] > bends_before[low]:
            continue
        hinge, information = _hinge(t, measured, low, i, high)
        if abs(hinge) * np.sqrt(information) > bent * noise:
            out[low:high] = True
    return out


@njit
def _hinge(t: Floats, measured: Floats, low: int, i: int, high: int) -> tuple[float, float]:
    """Return the bend ``c`` [m/s] of the line through the window, and 1 / var(c) for noise of one."""
    scale = t[high - 1] - t[low]
    level = measured[i] if not np.isnan(measured[i]) else 0.0
    s0, s1, s2, h0, h1, h2, y0, y1, yh = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(low, high):
        if np.isnan(measured[j]):
            continue
        y = measured[j] - level
        u = (t[j] - t[i]) / scale
        h = abs(u)
        s0, s1, s2 = s0 + 1.0, s1 + u, s2 + u * u
        h0, h1, h2 = h0 + h, h1 + h * u, h2 + h * h
        y0, y1, yh = y0 + y, y1 + y * u, yh + y * h
    det = s0 * s2 - s1 * s1
    if not det > 0.0:
        return 0.0, 0.0
    p, q = (h0 * s2 - h1 * s1) / det, (h1 * s0 - h0 * s1) / det  # |u| by the straight line
    left = h2 - p * h0 - q * h1
    if not left > 1e-9 * h2:
        return 0.0, 0.0
    return (yh - p * y0 - q * y1) / (left * scale), left * scale * scale


@njit
def smooth(t: Floats, first: Floats, y: Floats, R: float, q: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return position, its variance, squared mean of the acceleration, and ``q g' N g``, each (n,).

    The fixed-interval smoother of [DurbinKoopman2012]_, section 4.4: with innovation v, its variance F and
    gain K,

        ``r = h v / F + L' r+``,   ``N = h h' / F + L' N+ L``,   ``state | all = state + P r``
        ``a | all = q g' r``,   ``var(a | all) = q - q^2 g' N g``,   ``g = (0, dt)``

    The last two results are the terms of the fixed point ``q = a^2 / (q g' N g)`` [Tipping2001]_, eq. (16).
    """
    n = t.shape[0]
    x = np.empty((n, 2))
    P = np.empty((n, 3))
    gain = np.empty((n, 4))  # v / F, 1 / F, K_d, K_v
    for i in range(n):
        if first[i] > 0.0:
            x[i, 0], x[i, 1] = y[i], 0.0
            j = i
            while np.isnan(x[i, 0]) and j + 1 < n:
                j += 1
                x[i, 0] = y[j]
            step = t[i + 1] - t[i] if i + 1 < n else 1.0
            P[i, 0], P[i, 1], P[i, 2] = PRIOR_VARIANCE * R, 0.0, PRIOR_VARIANCE * R / (step * step)
        known = not np.isnan(y[i])
        F = P[i, 0] + R
        v = y[i] - x[i, 0] if known else 0.0
        a, b = (P[i, 0] / F, P[i, 1] / F) if known else (0.0, 0.0)
        gain[i, 0], gain[i, 1] = (v / F, 1.0 / F) if known else (0.0, 0.0)
        gain[i, 2], gain[i, 3] = a, b
        if i + 1 < n and first[i + 1] == 0.0:
            dt = t[i + 1] - t[i]
            d0, v0 = x[i, 0] + a * v, x[i, 1] + b * v
            p0, p1, p2 = P[i, 0] - a * P[i, 0], P[i, 1] - a * P[i, 1], P[i, 2] - b * P[i, 1]
            x[i + 1, 0], x[i + 1, 1] = d0 + dt * v0, v0
            P[i + 1, 0] = p0 + 2.0 * dt * p1 + dt * dt * p2
            P[i + 1, 1] = p1 + dt * p2
            P[i + 1, 2] = p2 + q[i] * dt * dt
    position, variance = np.empty(n), np.empty(n)
    jerk, share = np.zeros(n), np.zeros(n)
    r0, r1, n0, n1, n2 = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n - 1, -1, -1):
        if i == n - 1 or first[i + 1] > 0.0:
            r0, r1, n0, n1, n2 = 0.0, 0.0, 0.0, 0.0, 0.0
        else:
            dt = t[i + 1] - t[i]
            jerk[i] = (q[i] * dt * r1) ** 2
            share[i] = q[i] * dt * dt * n2
            n1, n2 = n1 + dt * n0, n2 + 2.0 * dt * n1 + dt * dt * n0  # T' N T
            r1 = r1 + dt * r0
        a, b = gain[i, 2], gain[i, 3]  # then through 1 - K h'
        r0 = gain[i, 0] + (1.0 - a) * r0 - b * r1
        keep = 1.0 - a
        n0, n1 = gain[i, 1] + keep * keep * n0 - 2.0 * keep * b * n1 + b * b * n2, keep * n1 - b * n2
        position[i] = x[i, 0] + P[i, 0] * r0 + P[i, 1] * r1
        spread = P[i, 0] * P[i, 0] * n0 + 2.0 * P[i, 0] * P[i, 1] * n1 + P[i, 1] * P[i, 1] * n2
        variance[i] = P[i, 0] - spread
    return position, variance, jerk, share


@njit
def posterior(t: Floats, first: Floats, y: Floats, R: float, q: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the error of the smoothed motion as a Markov chain: pull (n, 2), push (n,), start (n, 3).

    With the information I that the later samples hold of a state, ``p(state+ | state, later)`` has the noise
    ``g sqrt(c)``, ``c = q / (1 + q g' I g)``, and the transition ``T - c g g' I T``.
    """
    n = t.shape[0]
    pull, push, start = np.zeros((n, 2)), np.zeros(n), np.zeros((n, 3))
    i0, i1, i2 = 0.0, 0.0, 0.0
    for i in range(n - 1, -1, -1):
        if i == n - 1 or first[i + 1] > 0.0:
            i0, i1, i2 = 0.0, 0.0, 0.0
        else:
            dt = t[i + 1] - t[i]
            u0, u1 = i1 * dt, i2 * dt  # I g
            c = q[i] / (1.0 + q[i] * dt * u1)
            push[i] = np.sqrt(c)
            pull[i, 0], pull[i, 1] = c * u0, c * (u0 * dt + u1)
            i0, i1, i2 = i0 - c * u0 * u0, i1 - c * u0 * u1, i2 - c * u1 * u1
            i1, i2 = i1 + dt * i0, i2 + 2.0 * dt * i1 + dt * dt * i0
        if not np.isnan(y[i]):
            i0 += 1.0 / R
        if first[i] > 0.0:
            step = t[i + 1] - t[i] if i + 1 < n else 1.0
            b0, b2 = i0 + 1.0 / (PRIOR_VARIANCE * R), i2 + step * step / (PRIOR_VARIANCE * R)
            det = b0 * b2 - i1 * i1
            start[i, 0], start[i, 1], start[i, 2] = b2 / det, -i1 / det, b0 / det
    return pull, push, start


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of a recording.

    Attributes:
        displacement: (n,) [m] mean of the smoothed position.
        std: (n,) [m] its standard deviation.
        pull, push: (n, 2) and (n,) the smoothed error as a Markov chain, see
            :mod:`vegrip.identification.fit.whitening`:
            ``error+ = T error + g (push a - pull . error)``, ``a ~ N(0, 1)``.
        start: (n, 3) its covariance at the beginning of an episode: dd, dv, vv.

    """

    displacement: Floats
    std: Floats
    pull: Floats
    push: Floats
    start: Floats


def motion_of(t: Floats, first: Floats, measured: Floats, noise: float) -> Motion:
    """Smooth ``measured`` (n,) [m], NaN where missing, with white noise of ``noise`` [m].

    ``first`` is 1 where an episode begins; episodes do not know of each other.
    """
    dt = np.diff(t, append=t[-1] + 1.0)
    dt[np.r_[first[1:] > 0.0, True]] = 1.0  # from episode to episode nothing is carried over
    known = np.isfinite(measured)
    if noise <= 0.0:
        none = np.zeros(t.size)
        bridged = np.interp(t, t[known], measured[known])
        return Motion(bridged, none, np.zeros((t.size, 2)), none.copy(), np.zeros((t.size, 3)))
    one = (noise / dt**2) ** 2
    runs_straight = straight(t, first, measured, noise)
    q = np.where(runs_straight, STRAIGHT_SHARE**2, 100.0) * one
    for _ in range(MOTION_ROUNDS):
        position, variance, jerk, share = smooth(t, first, measured, noise**2, q)
        likely = _shared(jerk, first) / np.maximum(_shared(share, first), 1e-12)
        q = np.where(
            runs_straight,
            STRAIGHT_SHARE**2 * one,
            np.clip(likely, REST_STEP**2 * one, 1e12 * REST_STEP**2 * one),
        )
    position, variance, jerk, share = smooth(t, first, measured, noise**2, q)
    pull, push, start = posterior(t, first, measured, noise**2, q)
    return Motion(position, np.sqrt(np.maximum(variance, 0.0)), pull, push, start)


def _shared(values: Floats, first: Floats) -> Floats:
    half = ACCELERATION_STEPS // 2
    total = np.zeros_like(values)
    episode = np.cumsum(first > 0.0)
    for shift in range(-half, half + 1):
        moved = np.roll(values, shift)
        same = np.roll(episode, shift) == episode
        if shift > 0:
            same[:shift] = False
        elif shift < 0:
            same[shift:] = False
        total += np.where(same, moved, 0.0)
    return total
