"""A block of frames gives them as they came, and of each identifier the newest."""

import socket

import numpy as np

from vegrip.transport.codec.frame import EXTENDED, Frame, FrameBlock

FRAMES = [Frame(0x100, b"abc", True, 5), Frame(0x101, b"", True, 6), Frame(0x100, b"de", True, 7)]


def test_a_block_gives_its_frames_in_order_and_the_newest_of_each_identifier() -> None:
    starts = np.cumsum([0, *(len(frame.data) for frame in FRAMES)])
    rows = [
        [one.arbitration_id, one.stamp, at, len(one.data)] for one, at in zip(FRAMES, starts, strict=False)
    ]
    block = FrameBlock(b"".join(frame.data for frame in FRAMES), np.array(rows))
    assert block.frames() == FRAMES
    assert block.newest() == [FRAMES[2], FRAMES[1]]


def test_a_frame_is_classic_on_its_way_out_and_one_of_29_bits_is_marked_as_socketcan_does() -> None:
    assert Frame(0x100, b"") == (0x100, b"", False, 0)
    assert EXTENDED == socket.CAN_EFF_FLAG
