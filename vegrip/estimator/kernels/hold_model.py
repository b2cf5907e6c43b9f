"""A held contact: how indentation and force go on while the drive stands still.

Between the standing drive and the fingertip lies the stiffness k_d of the drive, so along the hold

    N(T) + k_d delta(T) = N(0) + k_d delta(0) .

``k_d = inf`` holds the indentation, ``k_d = 0`` the force; between them the force falls by less than at a
held indentation, and the indentation grows by less than at a held force. Steps of the model are exact for an
elastic force that is linear within the step, so a held indentation may be stepped as coarsely as one likes.
"""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.load_law import friction_factor

SOLVED = 1e-7  # of the force: what is left of the drive's equation
TRIES = 12


def begin_hold(m: Floats, y: int) -> tuple[float, float, float]:
    """Bring the states of ``y`` to its indentation, at once.

    Returns what the hold begins with: elastic force [N], indentation [m], force [N].
    """
    _, elastic_force, force, _ = advance(
        m, VALUES0, y + EFFECTS, m[y + DELTA], 0.0, EXOGENOUS0, 0.0, 0.0, TRIAL0
    )
    keep_hold(m, y, m[y + DELTA])
    return elastic_force, m[y + DELTA], force


def keep_hold(m: Floats, y: int, delta: float) -> None:
    """Take the step that was tried last: its indentation, and its states from S1."""
    m[y + DELTA] = delta
    for i in range(NS):
        m[y + EFFECTS + i] = m.trial[i]


def try_hold(
    m: Floats, y: int, before: float, dt: float, begun: tuple[float, float]
) -> tuple[float, float, float, float]:
    """Hold the state ``y`` for another dt [s]; states into S1. Returns ``delta, x, elastic_force, force``.

    ``before`` is the elastic force of ``y`` [N], ``begun`` indentation [m] and force [N] when the hold began.
    The drive's equation is solved by the secant method; the force grows with the indentation, so it has
    one solution.
    """
    origin, fresh = begun
    drive, delta = m.set.hold, m[y + DELTA]
    x, elastic, force, _ = advance(m, VALUES0, y + EFFECTS, delta, 0.0, EXOGENOUS0, before, dt, TRIAL0)
    if drive == math.inf:
        return delta, x, elastic, force
    left = fresh - force - drive * (delta - origin)
    slope = 1.5 * elastic / delta + drive if delta > 0.0 else 0.0
    for _ in range(TRIES):
        if not (abs(left) > SOLVED * fresh and slope > 0.0):
            break
        last, left_last, delta = delta, left, delta + left / slope
        x, elastic, force, _ = advance(m, VALUES0, y + EFFECTS, delta, 0.0, EXOGENOUS0, before, dt, TRIAL0)
        left = fresh - force - drive * (delta - origin)
        slope = (left_last - left) / (delta - last) if delta != last else 0.0
    return delta, x, elastic, force


def surface_of(m: Floats, delta: float, x: float, elastic: float, force: float) -> tuple[float, float, float]:
    """Return ``a, k, friction`` of the states in S1."""
    a, k, friction = readout(m, VALUES0, TRIAL0, delta, 0.0, EXOGENOUS0, x, elastic, force)
    return a, k, friction * friction_factor(m, force)
