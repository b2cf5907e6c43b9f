"""Laws that every contact obeys, for a fitted model over the depths and speeds that it was shown.

* nothing pushes before it touches,
* under a constant indentation the force does not grow,
* a cycle gives back no more work than was put in,
* pressing deeper takes no less force, once it pushes,
* the force stays bounded however long it is held.

An effect of the sensor may break none of them: it is the force of the contact that is looked at.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from vegrip.identification.fit.problem import Problem
from vegrip.model import ContactModel

TOLERANCE = 2e-3  # of the largest force, or of the work
PRESS_SAMPLES = 2000
HELD = 10.0  # times as long as was recorded
GROWN = 3.0  # times the force at the beginning of a hold
MOVES = 0.05  # of the quickest speed, above which it moves


def broken_by(model: ContactModel, problem: Problem) -> Iterator[str]:
    """Yield a sentence for each law that ``model`` breaks within what ``problem`` has recorded."""
    m = problem.measured
    if m.recording.is_step or not (problem.stiffness > 0.0).any():
        return
    rate = np.abs(np.gradient(m.motion.displacement, m.recording.t))
    quick = float(np.quantile(rate[problem.stiffness > 0.0], 0.99))
    moving = rate[(problem.stiffness > 0.0) & (rate > MOVES * quick)]
    slow = float(np.quantile(moving, MOVES))
    length = float(m.recording.t[-1] - m.recording.t[0])
    yield from broken_over(model, float(np.max(m.motion.displacement)), (slow, quick), length)


def broken_over(model: ContactModel, depth: float, speeds: Iterable[float], length: float) -> Iterator[str]:
    """Yield the same for presses to ``depth`` [m] at ``speeds`` [m/s] and holds of ``length`` [s]."""
    for speed in speeds:
        yield from _broken(model, depth, depth / speed, min(HELD * depth / speed, length))
    t = np.linspace(0.0, HELD * length, PRESS_SAMPLES)
    force = model.simulate(t, np.full(PRESS_SAMPLES, depth)).normal_force
    if not np.isfinite(force).all() or np.max(np.abs(force)) > GROWN * max(abs(float(force[0])), 1e-12):
        yield f"held for {t[-1]:.3g} s the force grows without bound"


def _broken(model: ContactModel, depth: float, rise: float, hold: float) -> Iterator[str]:
    """Check air, press, hold, return and once more, each press taking ``rise`` [s]."""
    corners = np.cumsum([0.0, 0.2 * rise, rise, hold, rise, 0.2 * rise, rise, 0.2 * rise, rise])
    at = np.array([-0.2, -0.02, 1.0, 1.0, -0.02, -0.02, 1.0, 1.0, -0.02]) * depth
    t = np.interp(np.linspace(0.0, 8.0, 8 * PRESS_SAMPLES // 4), np.arange(9.0), corners)
    x = np.interp(t, corners, at)
    made = model.simulate(t, x)
    force, felt = made.normal_force, made.indentation  # a drive with play moves without doing work
    peak = float(np.max(np.abs(force)))
    if not np.isfinite(force).all() or peak == 0.0:
        yield "the force is not finite"
        return
    part = np.searchsorted(corners, t, side="right") - 1
    speed = depth / rise
    said = f"at {1e3 * speed:.3g} mm/s"
    if np.max(np.abs(force[part == 0])) > TOLERANCE * peak:
        yield f"{said} it pushes before it touches"
    pressing, held = force[part == 1], force[part == 2]
    pressing = pressing[np.flatnonzero(pressing <= 0.0)[-1:].sum() :]  # surfaces may pull each other in first
    if held.size and np.max(held - np.minimum.accumulate(held)) > TOLERANCE * peak:
        yield f"{said} the force grows under a constant indentation"
    if np.max(np.maximum.accumulate(pressing) - pressing) > TOLERANCE * peak:
        yield f"{said} pressing deeper takes less force"
    for first, last in ((1, 3), (5, 7)):
        rows = (part >= first) & (part <= last)
        if np.trapezoid(force[rows], felt[rows]) < -TOLERANCE * peak * depth:
            yield f"{said} a cycle gives back more work than was put in"
