"""What a codec could not carry, beside what it refused."""

from collections import Counter
from typing import Protocol


class Lossy(Protocol):
    """What both codecs count."""

    clipped: Counter[str]

    @property
    def lost(self) -> int:
        """Messages that never arrived."""


def losses(codec: Lossy) -> dict[str, int]:
    """Return the counts that are not zero: ``lost`` on the way in, ``clipped`` quantities on the way out."""
    counts = {"lost": codec.lost, "clipped": codec.clipped.total()}
    return {name: count for name, count in counts.items() if count}
