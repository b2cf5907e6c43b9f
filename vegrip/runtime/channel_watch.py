"""Finds what each finger measures from its first states, and says which quantities that leaves unknown."""

import math
from collections.abc import Callable, Collection, Iterator

from vegrip.messages import FingertipState

CHANNELS = tuple(FingertipState.__dataclass_fields__)[3:]
Lacking = Callable[[Collection[str]], list[str]]
"""What a user must know of a finger with such channels."""

STATES = 50
"""States after which the channels of a finger are known: slower messages of the hand have come by then."""

MOST_FINGERS = 256  # are looked at; a sender of made-up names must not make the table grow


class ChannelWatch:
    """Collects the channels of each finger until they are known."""

    def __init__(self, lacking: Lacking, said: Collection[str] = ()) -> None:
        self.lacking = lacking
        self._said = frozenset(said)
        self._open: dict[str, tuple[int, frozenset[str]]] = {}
        self._known: dict[str, frozenset[str]] = {}
        self._fresh: list[str] = []  # fingers that became known
        self._news: list[str] = []

    def note(self, state: FingertipState) -> None:
        """Take in a state; a set is looked into once a finger is known."""
        if state.finger in self._known or len(self._open) + len(self._known) >= MOST_FINGERS:
            return
        count, channels = self._open.pop(state.finger, (0, frozenset()))
        channels |= {name for name in CHANNELS if not math.isnan(getattr(state, name))}
        if count + 1 < STATES:
            self._open[state.finger] = count + 1, channels
            return
        self._known[state.finger] = channels
        self._fresh.append(state.finger)
        sentences = (f"{state.finger}: {sentence}" for sentence in self.lacking(channels))
        self._news += [sentence for sentence in sentences if sentence not in self._said]

    def knows(self, finger: str) -> bool:
        """Return whether the channels of ``finger`` are known, so that no more of its states are needed."""
        return finger in self._known or len(self._open) + len(self._known) >= MOST_FINGERS

    def fresh(self) -> Iterator[tuple[str, frozenset[str]]]:
        while self._fresh and not self._open:
            finger = self._fresh.pop(0)
            yield finger, self._known[finger]

    def news(self) -> Iterator[str]:
        while self._news:
            yield self._news.pop(0)
