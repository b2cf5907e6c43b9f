"""Which differences there are: the smallest set that explains both recordings, and its rivals.

Sets of every size are compared, the best of each. A larger one is taken when twice what it gains would come
by chance less often than ``FALSE_CHANGE``, over as many questions as there are larger sets. Sets of one size
within 5 nats of the best cannot be distinguished from it; what all of them have is sure.
"""

from dataclasses import dataclass
from itertools import combinations
from math import comb

from scipy.special import chdtrc

from vegrip.identification.changed.pair import Pair
from vegrip.identification.diagnosis.thresholds import INDISTINGUISHABLE_NATS

FALSE_CHANGE = 1e-3  # chance that anything is said to have changed where nothing has
MOST_CHANGES = 4
MOST_STEPS = 8  # of Gauss and Newton
LAST_STEP_NATS = 0.01  # [nats] that the last one foretells
Set = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Choice:
    """The best set of differences, and all that explain as much, itself among them."""

    best: Set
    rivals: tuple[Set, ...]

    @property
    def sure(self) -> Set:
        return tuple(name for name in self.best if all(name in one for one in self.rivals))

    @property
    def unsure(self) -> list[tuple[int, Set]]:
        """How many of which differences there are: what takes each other's place belongs together."""
        best, groups = set(self.best), list[set[str]]()
        for one in sorted(map(set, self.rivals), key=lambda rival: len(rival - best)):
            is_resolved = all(len(one & group) == len(best & group) for group in groups)
            if not (is_resolved and one ^ best <= set().union(*groups)):
                touched = [group for group in groups if group & (one ^ best)]
                groups = [group for group in groups if group not in touched] + [(one ^ best).union(*touched)]
        order = [name for one in self.rivals for name in one]
        ordered = sorted([sorted(map(order.index, group)) for group in groups])
        sets = [tuple(order[i] for i in one) for one in ordered]
        return [(len(best.intersection(one)), one) for one in sets]


def choose(pair: Pair) -> Choice:
    """Return which differences there are; ``pair`` ends at its best with them."""
    for _ in range(MOST_STEPS):
        best = _best(pair)
        w, least = pair.solved(best)
        if 0.5 * float(pair.w @ pair.G @ pair.w) - float(pair.h @ pair.w) - least < LAST_STEP_NATS:
            break
        pair.move(w)
    most = pair.cost(best) + INDISTINGUISHABLE_NATS
    every = combinations(pair.questions, len(best))
    return Choice(best, tuple(one for one in every if pair.cost(one) <= most))


def _best(pair: Pair) -> Set:
    best: Set = ()
    for size in range(1, min(MOST_CHANGES, len(pair.questions)) + 1):
        one = min(combinations(pair.questions, size), key=pair.cost)
        added, gain = size - len(best), pair.cost(best) - pair.cost(one)
        if chance(gain, added, comb(len(pair.questions) - len(best), added)) < FALSE_CHANGE:
            best = one
        elif added > 1:  # two at once, as those of one effect, show where one alone does not
            break
    return best


def chance(gain: float, count: int, questions: int) -> float:
    """Return how likely ``count`` differences gain so much [nats] by chance, the best of ``questions``."""
    return min(questions * float(chdtrc(count, 2.0 * max(gain, 0.0))), 1.0)
