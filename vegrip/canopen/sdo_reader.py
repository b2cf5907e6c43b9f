"""Reading objects of a device by SDO without waiting: one request after the other, answers as they come.

The client of the package ``canopen`` waits for each answer in the thread that asks, which a loop must not.
"""

import struct
from collections.abc import Callable, Sequence

ANSWER_TIMEOUT_NS = 500_000_000  # [ns] for an answer
RETRIES = 3
UPLOAD, ABORT = 0x40, 0x80  # command specifiers; an expedited answer has bit 1, its size in bits 2 and 3


class SdoReader:
    """Reads numbers of at most 32 bits (expedited transfer) from one device.

    Args:
        asked: ``(index, sub-index)`` in the order of reading.
        send: takes the 8 bytes of a request.

    """

    def __init__(self, asked: Sequence[tuple[int, int]], send: Callable[[bytes], None]) -> None:
        self.values: dict[tuple[int, int], int | None] = {}
        """What was read; None where the device refused."""
        self.failed = False
        self._asked = list(asked)
        self._send = send
        self._sent: int | None = None  # [ns]
        self._tries = 0

    @property
    def is_done(self) -> bool:
        return self.failed or len(self.values) == len(self._asked)

    def serve(self, now: int) -> None:
        """Ask the next question, or again after ``ANSWER_TIMEOUT_NS``."""
        if self.is_done or (self._sent is not None and now - self._sent < ANSWER_TIMEOUT_NS):
            return
        if self._tries >= RETRIES:
            self.failed = True
            return
        self._tries += 1
        self._sent = now
        self._send(struct.pack("<BHB4x", UPLOAD, *self._asked[len(self.values)]))

    def answer(self, data: bytes, now: int) -> None:
        """Take the 8 bytes of an answer; one that was not asked for is passed over."""
        if self.is_done or len(data) != 8:
            return
        command, index, sub = struct.unpack_from("<BHB", data)
        if (index, sub) != self._asked[len(self.values)]:
            return
        if command == ABORT:
            self._take(None, now)
        elif command & 0xE2 == UPLOAD | 0x02:
            size = 4 - (command >> 2 & 3) if command & 1 else 4
            self._take(int.from_bytes(data[4 : 4 + size], "little"), now)

    def _take(self, value: int | None, now: int) -> None:
        self.values[self._asked[len(self.values)]] = value
        self._sent, self._tries = None, 0
        self.serve(now)
