"""The counters of all streams that are heard, in a table of bounded size.

Names come from outside, and a sender may make up any number of them. The streams of configured fingers have
places of their own; among all others the one that has been silent for longest gives way to a new one.
"""

from collections.abc import Collection
from typing import Final

from vegrip.transport.codec.sequence import Sequence

MOST_STRANGERS: Final = 1024
"""Streams kept besides those of configured fingers."""


class Streams:
    """One counter for each topic and owner.

    Args:
        fingers: names of the configured fingers; they are never crowded out.
        modulus: of the counters.

    """

    def __init__(self, fingers: Collection[str], modulus: int) -> None:
        self.crowded = 0  # streams that were forgotten to make room
        self._fingers = frozenset(fingers)
        self._modulus = modulus
        self._own: dict[tuple[str, str], Sequence] = {}
        self._strangers: dict[tuple[str, str], Sequence] = {}  # the one heard last stands last
        self._lost = 0  # by the streams that were forgotten

    @property
    def lost(self) -> int:
        """Messages that never arrived, over all streams there have been."""
        kept = (*self._own.values(), *self._strangers.values())
        return self._lost + sum(stream.lost for stream in kept)

    def of(self, topic: str, owner: str) -> Sequence:
        """Return the counter of what ``owner`` sends on ``topic``."""
        key = topic, owner
        if owner in self._fingers:
            if key not in self._own:
                self._own[key] = Sequence(self._modulus)
            return self._own[key]
        stream = self._strangers.pop(key) if key in self._strangers else self._new_stranger()
        self._strangers[key] = stream
        return stream

    def reset(self) -> None:
        """Begin all streams anew; what was counted stays counted."""
        for stream in (*self._own.values(), *self._strangers.values()):
            stream.last = -1

    def _new_stranger(self) -> Sequence:
        if len(self._strangers) >= MOST_STRANGERS:
            silent = next(iter(self._strangers))
            self._lost += self._strangers.pop(silent).lost
            self.crowded += 1
        return Sequence(self._modulus)
