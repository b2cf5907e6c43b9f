"""The recorder of the demonstration: it keeps frames while the hand holds, and decodes them afterwards."""

from collections.abc import Sequence

from vegrip.identification.recording.frame_log import FrameLog
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.frame import FrameBlock

FRAMES = "frames.log"
"""In the folder of the recording while the demonstration runs, and after one that was killed."""

HOLD_REASONS = (Reason.INPUT_HOLD, Reason.FAIL_SAFE)


class FrameRecorder:
    """Keeps the frames of one hand, and writes what they say when it is closed.

    Args:
        writer: of the recording.
        channel: name of the bus.
        fingers: of the hand, in the order of the bus.

    """

    def __init__(self, writer: RecordingWriter, channel: str, fingers: Sequence[str]) -> None:
        self.commands = 0
        """Commands since the hand has told of itself; known when it is closed, as the next."""
        self.held = 0  # of them that only held, because states came too late or not at all
        self.since: int | None = None  # [ns] when the hand told of itself first
        self._writer, self._fingers = writer, fingers
        self._log = FrameLog(writer.folder / FRAMES, channel)

    def offer(self, frame: Frame) -> None:
        """Keep ``frame``; never waits."""
        self._log.offer(frame)

    def offer_block(self, block: FrameBlock) -> None:
        """Keep all frames of ``block``; never waits."""
        self._log.offer_block(block)

    def flush(self) -> None:
        self._log.flush()

    def close(self) -> None:
        """Decode what was kept, write it to the recording, and close that."""
        self._log.flush()
        codec = CanCodec(self._fingers, fd=True, use_sender_time=True)
        for frame in self._log.frames():
            message = codec.decode(frame)
            if message is None:
                continue
            self._writer.write(message)
            if isinstance(message, ForceCommand) and self.since is not None and frame.stamp >= self.since:
                self.commands += 1
                self.held += message.reason in HOLD_REASONS
        self._writer.dropped = self._log.lost
        self._writer.close()
        if not self._writer.problem:
            self._log.path.unlink(missing_ok=True)
