"""``vegrip demo`` as a user runs it: contract of its JSON, its end, Ctrl-C, and nothing left behind."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.recording.session import read_fingers

KEYS = {
    "samples",
    "slips",
    "deadline_misses",
    "latency_us",
    "bus_load",
    "min_margin",
    "mean_grip_force",
    "cores",
    "recording",
}
pytestmark = pytest.mark.slow


def start(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "vegrip", "demo", "--headless", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # a process group of its own, as a shell gives it
        preexec_fn=_hear_ctrl_c,  # noqa: PLW1509 (no threads here)
    )


def _hear_ctrl_c() -> None:
    """Hear Ctrl-C even where these tests run in the background of a script, which ignores it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def members(group: int) -> list[int]:
    """Processes of a group that are still there."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if os.getpgid(int(entry.name)) == group:
                    found.append(int(entry.name))
            except ProcessLookupError:
                continue
    return found


def assert_nothing_left(group: int) -> None:
    deadline = time.monotonic() + 60.0
    while members(group) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert members(group) == []


@pytest.mark.long
def test_it_ends_by_itself_prints_its_contract_and_leaves_a_recording(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    process = start("--grasp", "hand", "--duration", "3", "--json", "--no-plot", "-o", str(folder))
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    assert "Traceback" not in err
    assert_nothing_left(process.pid)
    figures = json.loads(out)
    assert set(figures) == KEYS
    assert set(figures["latency_us"]) == {"p50", "p99", "max"}
    assert figures["samples"] > 1000
    assert 0.0 < figures["bus_load"] < 1.0
    assert math.isfinite(figures["min_margin"])
    assert 0.0 < figures["mean_grip_force"] < 75.0
    assert set(read_fingers(folder, announce=False)) == {"thumb", "index", "middle", "ring", "little"}


@pytest.mark.long
def test_as_a_product_it_holds_with_one_sensor_and_ctrl_c_ends_it_in_order(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    process = start("--as", "bota-sensone", "--duration", "600", "--no-plot", "-o", str(folder))
    frames = folder / "frames.log"
    deadline = time.monotonic() + 200
    while not (frames.exists() and frames.stat().st_size) and time.monotonic() < deadline:
        time.sleep(0.2)
    time.sleep(1.0)
    os.killpg(process.pid, signal.SIGINT)
    try:
        out, err = process.communicate(timeout=60)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == 130
    assert "states in" in out  # the summary of what there was
    assert "over serial" in out
    assert "Traceback" not in out + err
    assert not (folder / "tty").is_symlink()
    recorded = read_fingers(folder)  # written in the end from the frames, which are not needed then
    assert set(recorded) == {"tip"}
    assert np.median(np.diff(recorded["tip"].t)) == pytest.approx(0.01, rel=0.1)
    assert not frames.exists()
    assert_nothing_left(process.pid)


def test_a_folder_that_holds_a_recording_is_refused_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "session.toml").write_text("")
    assert main(["demo", "--headless", "-o", str(tmp_path)]) == 3
    assert len(capsys.readouterr().err.splitlines()) == 1
