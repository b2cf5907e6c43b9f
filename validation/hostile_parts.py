"""States in classic frames made false: their values, counters, versions, order, times and bytes."""

from collections.abc import Callable, Sequence

import numpy as np
from e2e.p11 import e2e_p11_protect

from vegrip.transport.codec import Frame

HEAD_AT, VALUES_AT, LENGTH = 1, 2, 8
"""Where counter, version and the mark of the last part stand, and the values: known here by itself."""
LAST, VERSIONS, COUNTERS = 0x80, 0x70, 0x0F
DATA_IDS = range(0x100, 0x1C0)
FIRST_PARTS = range(0x100, 0x140)
LATE_NS = 6_000_000  # [ns] more than all parts of a state may take

Sent = Sequence[tuple[int, Frame]]
"""Frames in place of one, each with what it is later [ns]."""
Way = Callable[[bytearray, int], None]


class PartLiar:
    """Makes the frames of a finger's states false in bursts.

    Args:
        seed: of what is done when.

    """

    BURST = 60  # frames at most
    WELL = 0.5  # share of bursts in which nothing is done
    ODD = (0x0000, 0x7FFF, 0x8000, 0x8001, 0xFFFF, 0x0001)

    def __init__(self, seed: tuple[int, int]) -> None:
        self._rng = np.random.default_rng(seed)
        self._ways: tuple[Way, ...] = (
            self._odd_value, self._random_value, self._missing, self._frozen, self._counter, self._version,
            self._ended, self._unended, self._slip, self._no_counter,
        )  # fmt: skip
        self._fates = (self._lost, self._twice, self._late, self._flipped, self._short, self._delayed_copy)
        self._left, self._way, self._fate = 0, -1, -1
        self._held: dict[int, bytes] = {}
        self._old: dict[int, Frame] = {}

    def falsified(self, frame: Frame) -> Sent:
        """Return what comes in place of a true frame, with a checksum that fits unless it is flipped."""
        if self._left <= 0:
            self._left = int(self._rng.integers(1, self.BURST))
            self._way = self._fate = -1
            self._held.clear()
            if self._rng.random() > self.WELL:
                self._way = int(self._rng.integers(-4, len(self._ways)))
                self._fate = int(self._rng.integers(-4, len(self._fates)))
        self._left -= 1
        data = bytearray(frame.data)
        if self._way >= 0:
            self._ways[self._way](data, frame.arbitration_id)
        e2e_p11_protect(data, frame.arbitration_id, increment_counter=False)
        found = frame._replace(data=bytes(data))
        is_struck = self._fate >= 0 and self._rng.random() < 0.2
        sent = self._fates[self._fate](found) if is_struck else ((0, found),)
        self._old[frame.arbitration_id] = found
        return sent

    def _lost(self, _: Frame) -> Sent:
        return ()

    def _twice(self, frame: Frame) -> Sent:
        return (0, frame), (0, frame)

    def _late(self, frame: Frame) -> Sent:
        return ((LATE_NS, frame),)

    def _flipped(self, frame: Frame) -> Sent:
        data = bytearray(frame.data)
        data[int(self._rng.integers(LENGTH))] ^= 1 << int(self._rng.integers(8))
        return ((0, frame._replace(data=bytes(data))),)

    def _short(self, frame: Frame) -> Sent:
        return ((0, frame._replace(data=frame.data[: int(self._rng.integers(LENGTH))])),)

    def _delayed_copy(self, frame: Frame) -> Sent:
        old = self._old.get(frame.arbitration_id, frame)
        return (0, old._replace(stamp=frame.stamp)), (0, frame)

    def _at(self) -> int:
        return VALUES_AT + 2 * int(self._rng.integers(3))

    def _odd_value(self, data: bytearray, _: int) -> None:
        at = self._at()
        data[at : at + 2] = int(self._rng.choice(self.ODD)).to_bytes(2, "little")

    def _random_value(self, data: bytearray, _: int) -> None:
        at = self._at()
        data[at : at + 2] = self._rng.bytes(2)

    def _missing(self, data: bytearray, identifier: int) -> None:
        if identifier in FIRST_PARTS:
            data[VALUES_AT : VALUES_AT + 2] = b"\x00\x80"

    def _frozen(self, data: bytearray, identifier: int) -> None:
        data[VALUES_AT:] = self._held.setdefault(identifier, bytes(data[VALUES_AT:]))

    def _counter(self, data: bytearray, _: int) -> None:
        moved = ((data[HEAD_AT] & COUNTERS) + int(self._rng.integers(-3, 4))) % 15
        data[HEAD_AT] = data[HEAD_AT] & ~COUNTERS | moved

    def _no_counter(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] |= COUNTERS if self._rng.random() < 0.1 else 0

    def _version(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] = data[HEAD_AT] & ~VERSIONS | int(self._rng.integers(3)) << 4

    def _ended(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] |= LAST

    def _unended(self, data: bytearray, _: int) -> None:
        data[HEAD_AT] &= ~LAST

    def _slip(self, data: bytearray, _: int) -> None:
        data[6] = int(self._rng.choice([0, 1, 2, 255]))
