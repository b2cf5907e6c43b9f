"""Frames that are kept come back as they were, also to the reader of logs."""

from pathlib import Path

import numpy as np

from vegrip.identification.recording.can_log import frames_of
from vegrip.identification.recording.frame_log import FrameLog
from vegrip.transport.codec import Frame


def some_frames(count: int) -> list[Frame]:
    rng = np.random.default_rng(0)
    sizes = {False: (0, 1, 8), True: (0, 8, 24, 48, 64)}
    frames = []
    for number in range(count):
        fd = bool(rng.random() < 0.5)
        data = rng.bytes(int(rng.choice(sizes[fd])))
        frames.append(Frame(int(rng.integers(0x800)), data, fd, 5_000_000_000 + 1000 * number))
    return frames


def test_frames_come_back_as_they_were(tmp_path: Path) -> None:
    log, frames = FrameLog(tmp_path / "frames.log", "demo"), some_frames(200)
    for number, frame in enumerate(frames):
        log.offer(frame)
        if number % 30 == 0:
            log.flush()
    log.flush()
    assert list(log.frames()) == frames
    assert list(frames_of(tmp_path / "frames.log")) == frames


def test_what_the_disk_does_not_take_is_counted(tmp_path: Path) -> None:
    log = FrameLog(tmp_path / "frames.log", "demo")
    (tmp_path / "frames.log").unlink()
    (tmp_path / "frames.log").mkdir()
    log.offer(Frame(1, b"", True, 0))
    log.flush()
    assert log.lost == 1
