"""Sudden losses of force that no motion explains: the material slipped or tore, and recovers.

No effect of a contact model makes them, and one such event pulls every parameter. A loss counts when the
force falls between neighbouring samples by far more than the noise and ten times faster than around it, while
the displacement goes on as before and the contact stays closed (a pull-off ends in air and is no event).
"""

from dataclasses import dataclass

import numpy as np

from vegrip.types import Floats

AROUND = 6  # samples to either side that say what is usual
MIN_SUDDEN_RATIO = 10.0  # times the steepest of those
MIN_FORCE_NOISES = 30.0  # of the force
MIN_FORCE_SHARE = 0.3  # of the force must be left, else the contact parted
RECOVERY_FACTOR = 2.0  # times as long as it took to regain the lost force is left out


@dataclass(frozen=True)
class Event:
    """A loss of force: row after which it begins, first row that counts again, time [s] and size [N]."""

    begin: int
    end: int
    time: float
    loss: float

    @property
    def rows(self) -> slice:
        """Rows to leave out."""
        return slice(self.begin + 1, self.end)


def find_events(t: Floats, first: Floats, displacement: Floats, force: Floats, noise: float) -> list[Event]:
    """Return the losses of ``force`` (n,) [N], NaN where missing, with white ``noise`` [N].

    Usual is the steepest change before a loss, and the middle one after it (the force springs back a little).
    """
    found: list[Event] = []
    fall, move = -np.diff(force), np.abs(np.diff(displacement))
    fall[first[1:] > 0.5] = np.nan
    ends = np.append(np.flatnonzero(first > 0.5), t.size)  # of the episodes
    for i in np.flatnonzero(np.nan_to_num(fall) > MIN_FORCE_NOISES * noise).tolist():
        if found and i < found[-1].end:
            continue
        before, after = slice(max(i - AROUND, 0), i), slice(i + 3, i + 3 + AROUND)
        usual, moved = np.abs(fall[before]), np.r_[move[before], move[after]]
        if usual.size < AROUND or not np.isfinite(np.r_[usual, fall[after]]).all():
            continue
        usually = max(float(usual.max()), float(np.median(np.abs(fall[after]))) if fall[after].size else 0.0)
        low = force[i + 1 : i + 4].min()
        if (
            force[i] - low > MIN_SUDDEN_RATIO * usually
            and move[i] <= 2.0 * moved.max()
            and low > MIN_FORCE_SHARE * force[i] > 0.0
        ):
            found.append(_event(i, t, int(ends[np.searchsorted(ends, i, side="right")]), force, low))
    return found


def _event(i: int, t: Floats, last: int, force: Floats, low: float) -> Event:
    """Follow an event until the force has long been back; at most to ``last``, the end of its episode."""
    back = np.flatnonzero(force[i + 1 : last] >= force[i])
    if not back.size:
        return Event(i, last, float(t[i + 1]), float(force[i] - low))
    again = t[i] + RECOVERY_FACTOR * (t[i + 1 + int(back[0])] - t[i])
    end = min(int(np.searchsorted(t, again, side="right")), last)
    return Event(i, end, float(t[i + 1]), float(force[i] - low))
