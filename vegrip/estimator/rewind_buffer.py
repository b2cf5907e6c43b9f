"""The last samples and what was known before each, so that a late one can still take its place."""

from collections import deque
from dataclasses import astuple

import numpy as np

from vegrip.messages import FingertipState
from vegrip.types import Floats, NamedNumbers


class RewindBuffer:
    """A ring of memories; noting one costs a copy of what lasts of the estimator's array.

    Args:
        depth: how many samples; 0 keeps none.
        size: length of what lasts, see :attr:`vegrip.estimator.layout.Layout.lasting`.

    """

    def __init__(self, depth: int, size: int) -> None:
        self._ring = np.zeros((max(depth, 1), size))
        self._samples: deque[tuple[FingertipState, FingertipState | None, int]] = deque(maxlen=depth)
        self._next = 0

    def note(self, sample: FingertipState, before: FingertipState | None, m: Floats) -> None:
        """Keep ``m``, the memory in which ``sample`` is about to be taken in after ``before``."""
        self._ring[self._next] = m[: self._ring.shape[1]]
        self._samples.append((sample, before, self._next))
        self._next = (self._next + 1) % len(self._ring)

    def rewind(self, stamp: int) -> tuple[Floats, FingertipState | None, list[FingertipState]] | None:
        """Go back to where a sample of ``stamp`` [ns] belongs.

        Returns the memory there, the sample before, and those after it, which are forgotten here; None when
        that is too long ago or a sample of that very stamp was taken.
        """
        if not self._samples or self._samples[-1][0].stamp == stamp:
            return None
        after = [i for i, (sample, _, _) in enumerate(self._samples) if sample.stamp > stamp]
        if not after:
            return None
        first, before, slot = self._samples[after[0]]
        if before is None or before.stamp >= stamp:
            return None
        later = [first, *(sample for sample, _, _ in list(self._samples)[after[0] + 1 :])]
        for _ in later:
            self._samples.pop()
        self._next = slot
        return self._ring[slot].copy(), before, later

    def write_to(self, memory: NamedNumbers) -> None:
        """Hand everything to the memory of a finger, where its step goes on."""
        memory.section("REWIND").reshape(self._ring.shape)[:] = self._ring
        stamps, before, begun = map(memory.section, ("REWIND_STAMP", "REWIND_BEFORE", "REWIND_BEGUN"))
        values = memory.section("REWIND_STATE").reshape(len(self._ring), -1)
        for sample, last, slot in self._samples:
            stamps[slot], values[slot] = sample.stamp, astuple(sample)[-values.shape[1] :]
            begun[slot], before[slot] = last is not None, 0 if last is None else last.stamp
        memory["SAMPLE_REWIND_NEXT"], memory["SAMPLE_KEPT"] = self._next, len(self._samples)

    def clear(self) -> None:
        """Forget all."""
        self._samples.clear()
