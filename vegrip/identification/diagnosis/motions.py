"""Whether what was accepted carries over from one motion to another.

Episodes that repeat one motion agree with each other about whatever imitates it: held out one by one, they
contradict nothing. So each motion by itself has to be explained better with an effect than without. Where
there is one motion only, and a tolerance lets pass what is not exact, nothing can contradict an effect, and
it stays a suggestion.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.candidate_fit import CandidateFit
from vegrip.identification.fit.problem import Problem
from vegrip.types import Floats

Kind = tuple[float, ...]
LOOKS = 60  # at the depth of a contact, for its way: between more, noise goes up and down
ONE_MOTION = (
    "every contact repeats one motion: what fits it within a tolerance may fail on another one; "
    "press to another depth, or at another speed, as well"
)


def motions_of(problem: Problem) -> NDArray[np.int64]:
    """Return for each row the number of its motion (rows of the recording,)."""
    m, touching = problem.measured, problem.stiffness > 0.0
    sliding = np.zeros(touching.size, dtype=bool)
    sliding[m.sliding] = True
    kinds: list[Kind] = []
    number = np.zeros(touching.size, dtype=np.int64)
    for start, rows in _contacts(problem, touching):
        kind = _kind(m.recording.t[rows], m.motion.displacement[rows], does_slide=bool(sliding[rows].any()))
        known = [i for i, other in enumerate(kinds) if _is_same(kind, other)]
        if not known:
            kinds.append(kind)
        number[start:] = known[0] if known else len(kinds) - 1
    return number


def _contacts(problem: Problem, touching: NDArray[np.bool_]) -> list[tuple[int, NDArray[np.int64]]]:
    """Return where each contact begins, the first with the recording, and its rows; no mere brush."""
    depth = problem.measured.motion.displacement
    deepest = float(np.nanmax(depth[touching])) if touching.any() else 0.0
    ends = np.flatnonzero((np.diff(touching.astype(np.int64)) != 0) | (np.diff(problem.episodes) != 0)) + 1
    stretches = np.split(np.arange(touching.size), ends)
    pressed = [
        rows
        for rows in stretches
        if touching[rows[0]] and float(np.max(depth[rows])) > thresholds.BRUSH_SHARE * deepest
    ]
    return [(int(rows[0]) if i else 0, rows) for i, rows in enumerate(pressed)]


def _kind(t: Floats, depth: Floats, *, does_slide: bool) -> Kind:
    """Return depth [m], speed of approach [m/s], 1 + the way over the depth, and whether it slides."""
    top = float(np.max(depth))
    high, low = (int(np.argmax(depth >= share * top)) for share in (0.9, 0.3))
    speed = (depth[high] - depth[low]) / max(t[high] - t[low], float(t[1] - t[0]) if t.size > 1 else 1.0)
    seen = depth[np.linspace(0, depth.size - 1, min(depth.size, LOOKS)).astype(np.int64)]
    path = float(np.sum(np.abs(np.diff(seen)))) / top
    return top, float(speed), 1.0 + path, float(does_slide)


def _is_same(one: Kind, other: Kind) -> bool:
    ratios = zip(one[:3], other[:3], thresholds.SAME_MOTION, strict=True)
    return one[3] == other[3] and all(max(a, b) <= most * max(min(a, b), 1e-12) for a, b, most in ratios)


def gains_by_motion(base: CandidateFit, new: CandidateFit, motions: NDArray[np.int64]) -> Floats:
    """Return what ``new`` gains beside ``base`` [nats] in each of ``motions`` (rows,), with common values.

    In directions that no parameter of the base can make up for, or it would be the base that is compared: of
    a motion that alone determines a relaxation time, say.
    """
    fresh, left = base.whitened(new), base.optimum.residual
    gains = []
    for number in np.unique(motions):
        rows = (motions == number) & base.problem.counted
        basis, _ = np.linalg.qr(base.optimum.jacobian[rows])
        before, after = (one[rows] - basis @ (basis.T @ one[rows]) for one in (left, fresh))
        gains.append(0.5 * float(before @ before - after @ after))
    return np.array(gains)


def is_contradicted(base: CandidateFit, new: CandidateFit, motions: NDArray[np.int64]) -> bool:
    """Whether ``new``, which extends ``base``, makes some of ``motions`` (rows,) worse."""
    change = gains_by_motion(base, new, motions)
    up, down = float(change[change > 0.0].sum()), -float(change[change < 0.0].sum())
    return down > thresholds.MAX_LOST_SHARE * up + thresholds.CHANCE_NATS


def unproven(problem: Problem, contests: Mapping[str, tuple[CandidateFit, CandidateFit]]) -> str:
    """Return why accepted effects are no more than a suggestion; empty where they are not.

    ``contests``: the model without each, and with it.
    """
    motions = motions_of(problem)
    if not motions.any():
        return ONE_MOTION if problem.measured.noise.tolerance else ""
    for name, (base, new) in contests.items():
        if is_contradicted(base, new, motions[problem.rows]):
            return f"with {name}, some motions are explained worse than without it"
    return ""
