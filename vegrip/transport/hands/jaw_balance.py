"""Whether two opposed fingers feel the same normal force, as both jaws of one drive must. Pure.

What one feels beyond the other, in the mean over :data:`MEAN_S`, is pressed by something else: the table, a
finger of a person, a stop. It may also be the object's weight along the closing direction, or a zero that
has drifted. Noise is known from the differences of successive readings, ``s^2 = mean (x_i - x_{i-1})^2 / 2``.
"""

import math
from dataclasses import dataclass
from typing import Final

from vegrip.clock import NOT_YET, NS

MEAN_S: Final = 0.5  # [s]
NOISES: Final = 4.0  # standard deviations of a single reading, which also covers how a zero wanders
GAIN_ERROR: Final = 0.1  # of the force: two sensors that are each known to 5 %
LEAST_N: Final = 0.5  # [N] below which a jaw may just be closing
LASTING_NS: Final = NS  # [ns] for which it must be so


@dataclass(slots=True)
class _Jaw:
    mean: float = math.nan  # [N]
    variance: float = 0.0  # [N^2] of the noise
    last: float = math.nan
    stamp: int = 0  # [ns]

    def note(self, force: float, stamp: int) -> None:
        if math.isnan(self.mean):
            self.mean = self.last = force
        gain = -math.expm1(-max(stamp - self.stamp, 0) / NS / MEAN_S)
        self.mean += gain * (force - self.mean)
        self.variance += gain * ((force - self.last) ** 2 / 2.0 - self.variance)
        self.last, self.stamp = force, stamp


class JawBalance:
    """Looks at the normal forces of two opposed fingers."""

    def __init__(self, one: str, other: str) -> None:
        self._jaws = {one: _Jaw(), other: _Jaw()}
        self._even = NOT_YET  # [ns] when they were even last

    @property
    def means(self) -> dict[str, float]:
        """The normal forces [N], by finger."""
        return {name: jaw.mean for name, jaw in self._jaws.items()}

    def note(self, finger: str, force: float, stamp: int) -> bool:
        """Take in a normal force [N] at ``stamp`` [ns]; return whether the two have long differed."""
        jaw = self._jaws.get(finger)
        if jaw is None or not math.isfinite(force):
            return False
        jaw.note(force, stamp)
        one, other = self._jaws.values()
        allowed = NOISES * math.sqrt(one.variance + other.variance)
        allowed += max(GAIN_ERROR * (one.mean + other.mean) / 2.0, LEAST_N)
        is_silent = abs(one.stamp - other.stamp) > MEAN_S * NS  # one of them: what it felt is no longer felt
        if self._even == NOT_YET or is_silent or not abs(one.mean - other.mean) > allowed:
            self._even = stamp
        return stamp - self._even > LASTING_NS
