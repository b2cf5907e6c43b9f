"""Frames kept as they came from the bus, to be decoded when there is time: a text file as candump writes it.

A program that records what real-time loops say on the same machine must cost them little: to keep a frame
takes a tenth of the time of decoding it and writing its row. The file is whole lines after every
:meth:`FrameLog.flush`, and ``vegrip import`` reads it, should the program not come to decode it.
"""

from collections.abc import Iterator
from pathlib import Path

from vegrip.clock import NS
from vegrip.identification.recording.frame_text import MICROSECOND, NO_FRAMES, lines_of
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import FrameBlock

FD_WITH_RATE_SWITCH = "##1"


class FrameLog:
    """A file of frames.

    Args:
        path: of the file, ``.log``; is made.
        channel: name of the bus.

    """

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
        with self.path.open(encoding="ascii") as file:
            for line in file:
                yield _frame(line)

    def _text(self, kept: Frame | FrameBlock) -> bytes:
        return lines_of(kept, self._channel) if isinstance(kept, FrameBlock) else self._line(kept).encode()

    def _line(self, frame: Frame) -> str:
        second, rest = divmod(frame.stamp, NS)
        mark = FD_WITH_RATE_SWITCH if frame.fd else "#"
        data = f"{mark}{frame.data.hex().upper()}"
        return f"({second}.{rest // MICROSECOND:06d}) {self._channel} {frame.arbitration_id:03X}{data}\n"


def _frame(line: str) -> Frame:
    time, _, text = line.split()
    second, _, rest = time[1:-1].partition(".")
    identifier, _, data = text.partition("#")
    fd = data.startswith("#")
    stamp = int(second) * NS + int(rest) * MICROSECOND
    return Frame(int(identifier, 16), bytes.fromhex(data[2:] if fd else data), fd, stamp)
