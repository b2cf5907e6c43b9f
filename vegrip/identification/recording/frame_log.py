"""Frames kept as they came from the bus, to be decoded when there is time: a text file as candump writes it.

A program that records what real-time loops say on the same machine must cost them little: to keep a frame
takes a tenth of the time of decoding it and writing its row. The file is whole lines after every
:meth:`FrameLog.flush`, and ``vegrip import`` reads it, should the program not come to decode it.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.compiled import njit
from vegrip.identification.recording.can_frames import candump_frames
from vegrip.identification.recording.report import LoadReport
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import FrameBlock

MICROSECOND: Final = 1000  # [ns]
HEX: Final = np.frombuffer(b"0123456789ABCDEF", np.uint8)
SIGNS: Final = 32  # of a line without the channel and the data: (s.us) id##1, 12 digits for the seconds
Bytes = NDArray[np.uint8]
NO_FRAMES: Final = FrameBlock(b"", np.zeros((0, 4), np.int64))
FD_WITH_RATE_SWITCH = "##1"


def lines_of(block: FrameBlock, channel: str) -> bytes:
    """Return a line for each frame of ``block``, seen on ``channel``."""
    rows = block.rows
    name = np.frombuffer(channel.encode("ascii"), np.uint8)
    text = np.empty(len(rows) * (SIGNS + len(name)) + 2 * int(rows[:, 3].sum()), np.uint8)
    length = _write_lines(np.frombuffer(block.data, np.uint8), rows, name, text)
    return text[:length].tobytes()


@njit
def _write_number(text: Bytes, at: int, number: int, least: int) -> int:
    """Write decimal digits, ``least`` or more; return where they end."""
    digits, rest = 1, number // 10
    while rest > 0:
        digits, rest = digits + 1, rest // 10
    digits = max(digits, least)
    for i in range(digits):
        text[at + digits - 1 - i] = 48 + number % 10
        number //= 10
    return at + digits


@njit
def _write_lines(data: Bytes, rows: NDArray[np.int64], channel: Bytes, text: Bytes) -> int:
    """Write ``(seconds.microseconds) channel ID##1DATA`` for each row; return how long all is."""
    at = 0
    for i in range(len(rows)):
        identifier, stamp, start, length = rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]
        text[at] = 40
        at = _write_number(text, at + 1, stamp // NS, 1)
        text[at] = 46
        at = _write_number(text, at + 1, stamp % NS // MICROSECOND, 6)
        text[at], text[at + 1] = 41, 32
        at += 2
        for k in range(len(channel)):
            text[at + k] = channel[k]
        at += len(channel)
        text[at] = 32
        for k in range(3):
            text[at + 1 + k] = HEX[identifier >> 4 * (2 - k) & 15]
        text[at + 4], text[at + 5], text[at + 6] = 35, 35, 49
        at += 7
        for k in range(start, start + length):
            text[at], text[at + 1] = HEX[data[k] >> 4], HEX[data[k] & 15]
            at += 2
        text[at] = 10
        at += 1
    return at


class FrameLog:
    """A file of frames."""

    def __init__(self, path: Path, channel: str) -> None:
        self.path = path
        self.lost = 0
        """Frames that the disk did not take."""
        self._channel = channel
        self._kept: list[Frame | FrameBlock] = []
        path.touch()
        lines_of(NO_FRAMES, channel)  # compiles, which a loop that records has no time for

    def offer(self, frame: Frame) -> None:
        """Keep ``frame``; never waits."""
        self._kept.append(frame)

    def offer_block(self, block: FrameBlock) -> None:
        """Keep all frames of ``block``; never waits."""
        self._kept.append(block)

    def flush(self) -> None:
        """Write out what was kept since."""
        kept, self._kept = self._kept, []
        try:
            with self.path.open("ab") as file:
                file.writelines(self._text(one) for one in kept)
        except OSError:
            self.lost += sum(len(one.rows) if isinstance(one, FrameBlock) else 1 for one in kept)

    def frames(self) -> Iterator[Frame]:
        """Yield what was written, oldest first."""
        yield from (frame for frame, _ in candump_frames(self.path, LoadReport()))

    def _text(self, kept: Frame | FrameBlock) -> bytes:
        return lines_of(kept, self._channel) if isinstance(kept, FrameBlock) else self._line(kept).encode()

    def _line(self, frame: Frame) -> str:
        second, rest = divmod(frame.stamp, NS)
        mark = FD_WITH_RATE_SWITCH if frame.fd else "#"
        data = f"{mark}{frame.data.hex().upper()}"
        return f"({second}.{rest // MICROSECOND:06d}) {self._channel} {frame.arbitration_id:03X}{data}\n"
