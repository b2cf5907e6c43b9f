"""Frames that are kept come back as they were, also to the reader of logs."""

from pathlib import Path

import numpy as np

from vegrip.identification.recording.can_frames import read_log
from vegrip.identification.recording.frame_log import FrameLog
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import FrameBlock


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
    assert read_log(tmp_path / "frames.log").frames == frames


def block_of(frames: list[Frame]) -> FrameBlock:
    rows, data = [], b"between"
    for frame in frames:
        rows.append((frame.arbitration_id, frame.stamp, len(data), len(frame.data)))
        data += frame.data + b"between"
    return FrameBlock(data, np.array(rows, np.int64))


def test_a_block_is_written_as_its_frames_are(tmp_path: Path) -> None:
    stamps = (0, 999, 1_000_001, 123_456_789_012_345, 2**62)
    frames = [one._replace(stamp=stamp) for stamp in stamps for one in some_frames(60) if one.fd]
    whole, single = (FrameLog(tmp_path / name, "demo-7") for name in ("whole.log", "single.log"))
    whole.offer(frames[0])
    whole.offer_block(block_of(frames[1:]))
    for frame in frames:
        single.offer(frame)
    for log in (whole, single):
        log.flush()
    assert whole.path.read_bytes() == single.path.read_bytes()


def test_what_the_disk_does_not_take_is_counted(tmp_path: Path) -> None:
    log = FrameLog(tmp_path / "frames.log", "demo")
    (tmp_path / "frames.log").unlink()
    (tmp_path / "frames.log").mkdir()
    log.offer(Frame(1, b"", True, 0))
    log.offer_block(block_of([Frame(1, b"", True, 0)] * 3))
    log.flush()
    assert log.lost == 4
