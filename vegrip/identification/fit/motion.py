"""The motion behind a noisy displacement: what moved smoothly, where it jerked, and how well that is known.

Two quantities, position and speed, straight within a step and bent at the samples by an acceleration,

    ``d+ = d + v dt``,   ``v+ = v + a dt``,   ``a ~ N(0, q)``,   ``measured = d + e``

(an acceleration that lasts through the step would leave a jump ringing for ever: it has a zero at half of
the sampling rate) with a variance q of its own for every step, found by maximum likelihood as in
[Tipping2001]_: where the drive
ramps or rests q goes to zero and the noise is averaged away, where it starts or stops q grows and nothing is
rounded off. Where a straight line is as good (:mod:`vegrip.identification.fit.straight`) no jerk is looked
for: the largest of thousands of errors looks like one, and a law that remembers its way (friction, wear) adds
up every such step.

Why: a candidate that follows the displacement late (lag, backlash) averages the noise of the motion away
and would so explain a recording better that has neither. Behind a smoothed motion there is no such noise.
"""

from dataclasses import dataclass

import numpy as np

from vegrip.identification.fit.smoother import posterior, smooth
from vegrip.identification.fit.straight import straight
from vegrip.types import Floats

MOTION_ROUNDS = 20
ACCELERATION_STEPS = (
    5  # steps that share a variance of the acceleration; one alone takes single errors for jerks
)
REST_STEP = 5e-3  # accelerations that move less than this many standard deviations in a step are rest, and
STRAIGHT_SHARE = 1e-4  # what is allowed where the motion is straight to within the noise


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
    dt[np.r_[first[1:] > 0.5, True]] = 1.0  # from episode to episode nothing is carried over
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
    """Return the sums over neighbouring steps of the same episode."""
    half = ACCELERATION_STEPS // 2
    total = np.zeros_like(values)
    episode = np.cumsum(first > 0.5)
    for shift in range(-half, half + 1):
        moved = np.roll(values, shift)
        same = np.roll(episode, shift) == episode
        if shift > 0:
            same[:shift] = False
        elif shift < 0:
            same[shift:] = False
        total += np.where(same, moved, 0.0)
    return total
