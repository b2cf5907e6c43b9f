"""Restores the order of messages that overtook each other, within a stated window.

A state that comes after a gap waits until what is missing has come, but no longer than the window: then the
missing one counts as lost, and should it come after all, as late. Everything that comes in order passes at
once, so that the window costs time only where something is missing.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from vegrip.messages import FingertipState, Message

Arrived = tuple[Message, int]
"""A message and when it came [ns]."""

MOST_HELD = 32  # messages of a finger; a sender of wild numbers must not make it grow


class InOrder:
    """The order of the states of every finger; other messages pass.

    Args:
        window: for how long a state may wait for another [ns].

    """

    def __init__(self, window: int) -> None:
        self.window = window
        self.faults: Counter[str] = Counter()  # "late": came after the window; "reordered": put back in place
        self._next: dict[str, int] = {}  # by finger, the number that is expected
        self._stamp: dict[str, int] = {}  # [ns] by finger, of the last one passed on
        self._held: dict[str, list[tuple[FingertipState, int]]] = {}

    def restore(self, messages: Sequence[Message], arrivals: Sequence[int], now: int) -> list[Arrived]:
        """Return what may go on at ``now`` [ns], in order: of what has just come, and of what was waiting."""
        passed: list[Arrived] = []
        for message, arrival in zip(messages, arrivals, strict=True):
            if isinstance(message, FingertipState):
                self._take(message, arrival, passed)
            else:
                passed.append((message, arrival))
        for finger, held in self._held.items():
            while held and (now - held[0][1] >= self.window or len(held) > MOST_HELD):
                self._next[finger] = held[0][0].seq
                self._pass_on(finger, passed)
        return passed

    def _take(self, state: FingertipState, arrival: int, passed: list[Arrived]) -> None:
        finger = state.finger
        if state.seq < self._next.get(finger, state.seq):
            self.faults["late"] += 1
            return
        held = self._held.setdefault(finger, [])
        if held and state.seq < held[-1][0].seq:
            self.faults["reordered"] += 1
        held.append((state, arrival))
        held.sort(key=lambda one: one[0].seq)
        self._next.setdefault(finger, state.seq)
        self._pass_on(finger, passed)

    def _pass_on(self, finger: str, passed: list[Arrived]) -> None:
        held = self._held[finger]
        while held and held[0][0].seq <= self._next[finger]:
            state, arrival = held.pop(0)
            stamp = self._in_place(state, held)
            self._stamp[finger], self._next[finger] = stamp, state.seq + 1
            passed.append((state if stamp == state.stamp else replace(state, stamp=stamp), arrival))

    def _in_place(self, state: FingertipState, held: Sequence[tuple[FingertipState, int]]) -> int:
        """Return the stamp of ``state``; one that is not in order is put between its neighbours'."""
        after = held[0][0].stamp if held else state.stamp + 1
        before = self._stamp.get(state.finger, min(state.stamp, after) - 1)
        return state.stamp if before < state.stamp < after else max(before + 1, (before + after) // 2)
