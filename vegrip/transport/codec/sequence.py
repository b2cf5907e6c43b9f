"""Counters of received messages: a gap is a loss, a repeat or a step back is refused.

The compiled step of CAN FD counts the same in :mod:`vegrip.grip.kernels.receive`.

Names come from outside, and a sender may make up any number of them. The streams of configured fingers have
places of their own; among all others the one that has been silent for longest gives way to a new one.
"""

from collections.abc import Collection
from typing import Final

from vegrip.types import NamedNumbers

RESYNC: Final = 500_000_000
"""[ns] A stream silent for longer may go on anywhere: its sender has started again."""

MOST_SKIPPED: Final = 10_000
"""Messages that can be lost in a row within ``RESYNC``: those of a stream of 20 kHz. A counter that jumps
further is not that of the next message of this stream."""


class Sequence:
    """The counter of one stream, made an ever-growing number.

    A counter modulo ``m`` that moved by ``d = (counter - last) mod m`` is a repeat for d = 0, has lost
    d - 1 messages for d <= m // 2, and ran backwards for any larger d. One that jumped further than
    ``MOST_SKIPPED`` is refused as well, until the stream has been silent for ``RESYNC``: one wrong counter
    must neither end the stream it stands in nor count as messages that were never sent.

    >>> stream = Sequence(15)
    >>> [stream.advance(counter, stamp=0) for counter in (13, 14, 0, 0, 2, 1)]
    [13, 14, 15, None, 17, None]
    >>> stream.lost
    1

    With a ``reach`` a message that was overtaken by at most so many others is taken nevertheless, once, under
    its own, older number, and is lost no more.
    """

    __slots__ = ("_reach", "_seen", "last", "lost", "modulus", "stamp")

    def __init__(self, modulus: int, reach: int = 0) -> None:
        self.modulus = modulus
        self._reach = reach
        self.stamp = 0
        self.lost = 0
        self.last = -1
        self._seen = (1 << self._reach + 1) - 1  # bit i: last - i has been taken, or is before the first

    def write_to(self, memory: NamedNumbers) -> None:
        """Put last number, time and losses into a memory; only of a stream without ``reach``."""
        memory["LINE_LAST"], memory["LINE_STAMP"], memory["LINE_LOST"] = self.last, self.stamp, self.lost

    def read_from(self, memory: NamedNumbers) -> None:
        self.last, self.stamp = int(memory["LINE_LAST"]), int(memory["LINE_STAMP"])
        self.lost = int(memory["LINE_LOST"])

    def is_behind(self, counter: int) -> bool:
        return self.last >= 0 and (counter - self.last) % self.modulus > self.modulus // 2

    def advance(self, counter: int, stamp: int) -> int | None:
        """Return the running number of the message received at ``stamp`` [ns], None to refuse it."""
        step = (counter - self.last) % self.modulus
        if self.last < 0:
            self.last = counter
        elif step == 1 and not self._reach:
            self.last += 1
        else:
            was_silent = stamp - self.stamp > RESYNC
            if self._reach and 0 < self.modulus - step <= self._reach and not was_silent:
                return self._overtaken(self.modulus - step)
            if step == 0 or (step > min(self.modulus // 2, MOST_SKIPPED) and not was_silent):
                return None
            self.last += step
            self._seen = ((self._seen << min(step, self._reach + 1)) | 1) & ((1 << self._reach + 1) - 1)
            if not was_silent:
                self.lost += step - 1
        self.stamp = stamp
        return self.last

    def _overtaken(self, back: int) -> int | None:
        if self._seen >> back & 1:
            return None
        self._seen |= 1 << back
        self.lost -= 1
        return self.last - back


MOST_STRANGERS: Final = 1024
"""Streams kept besides those of configured fingers."""


class Streams:
    """One counter for each topic and owner; those of the configured ``fingers`` are never crowded out."""

    def __init__(self, fingers: Collection[str], modulus: int) -> None:
        self.crowded = 0  # streams that were forgotten to make room
        self._fingers = frozenset(fingers)
        self._modulus = modulus
        self._own: dict[tuple[str, str], Sequence] = {}
        self._strangers: dict[tuple[str, str], Sequence] = {}  # the one received last stands last
        self._lost = 0  # by the streams that were forgotten

    @property
    def lost(self) -> int:
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

    def _new_stranger(self) -> Sequence:
        if len(self._strangers) >= MOST_STRANGERS:
            silent = next(iter(self._strangers))
            self._lost += self._strangers.pop(silent).lost
            self.crowded += 1
        return Sequence(self._modulus)
