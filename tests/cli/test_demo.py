"""``vegrip demo`` as a user runs it: contract of its JSON, its end, Ctrl-C, and nothing left behind."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

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


def test_it_ends_by_itself_prints_its_contract_and_leaves_a_recording(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    process = start("--grasp", "hand", "--duration", "4", "--json", "--no-plot", "-o", str(folder))
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    figures = json.loads(out)
    assert set(figures) == KEYS
    assert set(figures["latency_us"]) == {"p50", "p99", "max"}
    assert figures["samples"] > 1000
    assert 0.0 < figures["bus_load"] < 1.0
    assert math.isfinite(figures["min_margin"])
    assert 0.0 < figures["mean_grip_force"] < 75.0
    fingers = read_fingers(folder, announce=False)
    assert set(fingers) == {"thumb", "index", "middle", "ring", "little"}
    assert "Traceback" not in err
    assert_nothing_left(process.pid)


def test_it_speaks_as_a_product_and_holds_with_one_sensor(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    process = start("--as", "bota-sensone", "--duration", "4", "--json", "--no-plot", "-o", str(folder))
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    assert 100 < json.loads(out)["samples"] < 1000  # 100 a second, its opening and all
    assert "over serial" in err
    assert not (folder / "tty").is_symlink()
    recorded = read_fingers(folder, announce=False)
    assert set(recorded) == {"tip"}
    assert "Traceback" not in err
    assert_nothing_left(process.pid)


def test_ctrl_c_ends_it_in_order(tmp_path: Path) -> None:
    process = start("--duration", "600", "--no-plot", "-o", str(tmp_path / "demo"))
    frames = tmp_path / "demo" / "frames.log"
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
    assert read_fingers(tmp_path / "demo")  # written in the end from the frames, which are not needed then
    assert not frames.exists()
    assert "Traceback" not in out + err
    assert_nothing_left(process.pid)


def test_a_folder_that_holds_a_recording_is_refused_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "session.toml").write_text("")
    process = start("--duration", "4", "-o", str(tmp_path))
    _, err = process.communicate(timeout=60)
    assert process.returncode == 3
    assert len(err.strip().splitlines()) == 1
    assert_nothing_left(process.pid)
