"""A CAN log gives back what was on the bus, and names what it could not use."""

import math
from pathlib import Path

import can
import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import RecordingError
from vegrip.identification.recording.can_log import read_can_log
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.transport.codec import CanCodec

FINGERS = ("thumb", "index")


def log(path: Path, fd: bool, *, damaged: bool = False) -> list[FingertipState]:
    """Write a log of two fingers at 100 Hz, with commands in between."""
    codec = CanCodec(FINGERS, fd=fd)
    states = []
    with can.Logger(path) as logger:
        for i in range(20):
            for finger in FINGERS:
                state = FingertipState(i, finger, i, normal_force=0.25 * i, displacement=1e-3, slip=i % 2)
                states.append(state)
                command = ForceCommand(i, finger, i, 1.0, 0.0, Reason.HOLD, i + 1_000_000)
                for frame in [*codec.encode(state), *codec.encode(command)]:
                    data = bytearray(frame.data)
                    if damaged and i == 7 and finger == "index":
                        data[4] ^= 0x55
                    logger(
                        can.Message(
                            timestamp=1000.0 + 0.01 * i + (0.002 if finger == "index" else 0.0),
                            arbitration_id=frame.arbitration_id,
                            is_extended_id=False,
                            data=data,
                            is_fd=fd,
                            is_rx=True,
                            channel=0,
                        )
                    )
    return states


@pytest.mark.parametrize("suffix", [".asc", ".blf", ".log"])
@pytest.mark.parametrize("fd", [False, True])
def test_a_log_becomes_one_recording_per_finger(suffix: str, fd: bool, tmp_path: Path) -> None:
    states = log(tmp_path / f"bus{suffix}", fd)
    fingers = read_can_log(tmp_path / f"bus{suffix}", FINGERS, radius=0.01)
    assert tuple(fingers) == FINGERS
    for finger, recording in fingers.items():
        sent = [state for state in states if state.finger == finger]
        assert list(recording.columns) == ["displacement", "normal_force", "slip"]
        np.testing.assert_allclose(np.diff(recording.t), 0.01, atol=2e-6)  # .asc keeps microseconds
        for name, values in recording.columns.items():
            np.testing.assert_allclose(values, [getattr(s, name) for s in sent], atol=1e-6)
        assert (recording.fingertip.radius, recording.fingertip.name) == (0.01, finger)
    assert fingers["index"].t[0] - fingers["thumb"].t[0] == pytest.approx(0.002, abs=1e-6)


def test_a_damaged_frame_is_left_out_and_named(tmp_path: Path) -> None:
    log(tmp_path / "bus.asc", fd=True, damaged=True)
    recording = read_can_log(tmp_path / "bus.asc", FINGERS)["index"]
    assert len(recording) == 19
    assert "frames refused: checksum" in recording.report.summary()
    assert math.isnan(recording.fingertip.radius)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("absent.asc", None, "there is no such file"),
        ("text.blf", b"this is no log", "is not a CAN log that can be read"),
        ("long.blf", b"this is no log" * 40, "is not a CAN log that can be read"),
        ("binary.asc", bytes(range(256)), "is not a CAN log that can be read"),
        ("empty.asc", b"", "none of its 0 frames is a fingertip's state"),
        (
            "other.asc",
            b"date Mon Sep 30 15:06:13 2019\nbase hex timestamps absolute\n",
            "none of its 0 frames",
        ),
    ],
)
def test_what_is_no_log_of_a_hand_is_refused(
    name: str, content: bytes | None, sentence: str, tmp_path: Path
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(RecordingError, match=name) as refused:
        read_can_log(tmp_path / name, FINGERS)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    "line",
    [
        "  can0  311   [8]  11 22 33 44 55 66 77 88",
        " (0.000000)  can0  200  [48]  4E F1",
        " (2026-11-25 10:00:00.1)  vcan1  18FF0001   [2]  01 02",
    ],
)
def test_what_candump_shows_on_a_screen_is_no_log_and_it_is_said_how_to_write_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], line: str
) -> None:
    shown = tmp_path / "drive.log"
    shown.write_text(f"{line}\n" * 3, encoding="utf-8")
    with pytest.raises(RecordingError, match="candump -L can0"):
        read_can_log(shown, FINGERS)
    assert main(["import", str(shown), "-o", str(tmp_path / "drive")]) != 0
    assert "candump -L can0" in capsys.readouterr().err
