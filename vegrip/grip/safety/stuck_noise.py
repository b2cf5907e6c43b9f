"""Whether the noise that a sensor shows while it lives has vanished: a value that stands still much too long.

A live sensor whose noise is not small against its resolution seldom says the same number twice running. With
the share *p* of such repeats, *n* of them in a row happen by chance once in *p^-n* states, so a handful of
equal values proves that it is stuck. What is seldom is learned from the sensor itself while it is well:

* *p*, the share of states that repeat the one before; twice that and three standard deviations more are
  counted on, because motion makes repeats rarer than they are at rest;
* *r*, the share of states that turn the direction of the last change: 2/3 for white noise, 0 for a smooth
  signal. Only with *r* > 0.3 are the changes the work of noise (a drift of at most 1.5 of its standard
  deviations a state, which takes *p* to 0.57 of its value at rest). A coarse sensor at rest, one that is
  filtered, and one that is read more often than it measures are not judged.
"""

import math
from operator import attrgetter

from vegrip.messages import FingertipState
from vegrip.types import NamedNumbers

WINDOW_SAMPLES = 256
"""States over which the shares are averaged; before so many nothing is judged."""

NOISY = 0.3
"""Share of turns above which the changes are noise."""

AT_REST = 2.0
"""By how much repeats may be more frequent at rest than they were."""

FORGIVEN = 2
"""A run of repeats is learned from up to so many times the length that was judged impossible."""


class StuckNoise:
    """Watches the channel ``name`` of one finger."""

    def __init__(self, name: str) -> None:
        self._read = attrgetter(name)
        self._last = math.nan
        self._change = 0.0  # the last one that was not zero
        self._run = 0  # repeats up to now
        self._limit = math.inf  # repeats that are too many for this run
        self._repeats = self._turns = 0.0  # shares
        self._count = 0

    def vanished(self, state: FingertipState, chance: float) -> bool:
        """Take in ``state``; return whether so many repeats have a chance of less than ``chance``.

        A value that is missing neither repeats nor changes.
        """
        value = self._read(state)
        if value == self._last:
            if not self._run:
                self._limit = self._longest(chance)
            self._run += 1
            return self._run >= self._limit
        if value == value:  # noqa: PLR0124 (NaN is not itself)
            self._learn(value)
            self._last = value
        return False

    def write_to(self, memory: NamedNumbers) -> None:
        """Put what is known into a memory."""
        memory["WATCH_NOISE_LAST"], memory["WATCH_CHANGE"] = self._last, self._change
        memory["INPUT_RUN"], memory["WATCH_REPEAT_LIMIT"] = self._run, self._limit
        memory["WATCH_REPEATS"], memory["WATCH_TURNS"] = self._repeats, self._turns
        memory["INPUT_COUNT"] = self._count

    def read_from(self, memory: NamedNumbers) -> None:
        """Take what is known from where :meth:`write_to` puts it."""
        self._last, self._change = memory["WATCH_NOISE_LAST"], memory["WATCH_CHANGE"]
        self._run, self._limit = int(memory["INPUT_RUN"]), memory["WATCH_REPEAT_LIMIT"]
        self._repeats, self._turns = memory["WATCH_REPEATS"], memory["WATCH_TURNS"]
        self._count = int(memory["INPUT_COUNT"])

    def _learn(self, value: float) -> None:
        """Average over the run of repeats that ends, and the change that ends it."""
        run: float = min(self._run, FORGIVEN * self._limit)
        if run:
            kept = (1.0 - self._gain) ** run
            self._repeats = 1.0 - (1.0 - self._repeats) * kept
            self._turns *= kept
            self._count += self._run
        change = value - self._last
        turned = change * self._change < 0.0
        self._repeats -= self._repeats * self._gain
        self._turns += (turned - self._turns) * self._gain
        if change == change:  # noqa: PLR0124
            self._change = change
        self._count += 1
        self._run = 0

    @property
    def _gain(self) -> float:
        return 1.0 / min(self._count + 1, WINDOW_SAMPLES)

    def _longest(self, chance: float) -> float:
        if chance <= 0.0 or self._count < WINDOW_SAMPLES or self._turns < NOISY:
            return math.inf
        p = self._repeats
        bound = AT_REST * p + 3.0 * math.sqrt(p * (1.0 - p) / WINDOW_SAMPLES) + 3.0 / WINDOW_SAMPLES
        return math.ceil(math.log(chance) / math.log(bound)) if bound < 1.0 else math.inf
