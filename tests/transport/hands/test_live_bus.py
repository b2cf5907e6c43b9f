"""A gripper of another make on a live bus: asked for its map by questions, then launched, margin and all."""

import os
import pty
import subprocess
import sys
import threading
import time
import tomllib
from collections.abc import Iterator
from contextlib import closing, suppress

import can
import pytest

from vegrip.cli import main
from vegrip.identification.samples import FOREIGN_DATABASE, FOREIGN_LOG, SAMPLES
from vegrip.messages import SlipMargin
from vegrip.runtime.registry import find_node
from vegrip.runtime.telemetry_socket import TelemetryReader

pytestmark = pytest.mark.slow

PATIENCE = 120.0  # [s] on a busy machine
WINDOWS = {"rest": (0.0, 2.0), "press": (2.0, 5.0), "shear": (5.0, 8.0), "twist": (8.0, 10.0)}
CHANNEL = "gripper"
SET_GRIP = 1041


class Player:
    """Sends a part of the log again and again, at its own pace."""

    def __init__(self, log) -> None:
        with can.BLFReader(str(log)) as reader:
            self._messages = list(reader)
        self._window = (0.0, 10.0)
        self._again = threading.Event()
        self._stop = threading.Event()
        self.heard: list[can.Message] = []
        self._bus = can.Bus(interface="vegrip", channel=CHANNEL, bitrate=1_000_000)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def play(self, window: tuple[float, float]) -> None:
        """Begin with another part."""
        self._window = window
        self._again.set()

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self._bus.shutdown()

    def _run(self) -> None:
        begin = self._messages[0].timestamp
        while not self._stop.is_set():
            self._again.clear()
            low, high = self._window
            started = time.monotonic()
            for message in self._messages:
                at = message.timestamp - begin
                if not low <= at < high or self._again.is_set() or self._stop.is_set():
                    continue
                while (left := started + at - low - time.monotonic()) > 0.0:
                    if (heard := self._bus.recv(left)) is not None:
                        self.heard.append(heard)
                self._send(message)

    def _send(self, message: can.Message) -> None:
        """Send a copy; while nobody listens, nothing is acknowledged, and it is lost."""
        copy = can.Message(arbitration_id=message.arbitration_id, data=message.data,
                           is_extended_id=message.is_extended_id)  # fmt: skip
        with suppress(can.CanOperationError):
            self._bus.send(copy)


@pytest.fixture
def gripper(runtime, tmp_path, monkeypatch) -> Iterator[Player]:
    monkeypatch.chdir(tmp_path)
    for name in (FOREIGN_DATABASE, FOREIGN_LOG):
        SAMPLES[name].write(tmp_path / name)
    with closing(Player(tmp_path / FOREIGN_LOG)) as player:
        yield player


@pytest.mark.long
def test_the_questions_are_answered_in_a_terminal_while_the_hand_is_on_the_bus(gripper, tmp_path) -> None:
    ours, theirs = pty.openpty()
    command = [
        sys.executable,
        "-m",
        "vegrip",
        "connect",
        FOREIGN_DATABASE,
        "-o",
        "hand.toml",
        "--channel",
        CHANNEL,
    ]
    process = subprocess.Popen(
        [*command, "--interface", "vegrip", "--seconds", "3"], stdin=theirs, stdout=theirs, stderr=theirs
    )
    os.close(theirs)
    said = ""
    with open(ours, "r+b", buffering=0) as terminal:  # noqa: PTH123 (a descriptor)
        for name, window in WINDOWS.items():
            while f"{name}: for 3 s" not in said or not said.endswith("to begin."):
                said += terminal.read(1000).decode()
            gripper.play(window)
            said = ""
            terminal.write(b"\n")
        while (more := _read(terminal)) and process.poll() is None:
            said += more
        assert process.wait(PATIENCE) == 0, said
    left = tomllib.loads((tmp_path / "hand.toml").read_text())["fingers"]["left"]
    assert left["normal_force"]["signal"] == "TIP_L.LoadA"
    assert left["tangential_force_x"]["signal"] == "TIP_L.LoadC"
    assert (left["normal_force"]["sign"], left["displacement"]["sign"]) == (-1, -1)
    assert left["normal_force"]["zero"] == pytest.approx(30.0, abs=0.5)


def _read(terminal) -> str:
    """Read what there is; nothing when the other end has gone."""
    try:
        return terminal.read(1000).decode()
    except OSError:
        return ""


LAUNCH = f"""
fingers = ["left", "right"]
[transport]
kind = "can"
interface = "vegrip"
channel = "{CHANNEL}"
fd = false
map = "hand.toml"
[[node]]
program = "grasp_force"
wait = true
loop.deadline = 0.2
parameters.suspects = false
"""


@pytest.mark.long
def test_a_mapped_hand_on_a_bus_has_its_margin_live_and_gets_commands_in_its_units(gripper, tmp_path) -> None:
    windows = [part for name, (low, high) in WINDOWS.items() for part in (f"--{name}", f"{low:g}..{high:g}")]
    assert (
        main(["connect", FOREIGN_DATABASE, "-o", "hand.toml", "--log", FOREIGN_LOG, *windows, "--json"]) == 0
    )
    (tmp_path / "launch.toml").write_text(LAUNCH)
    process = subprocess.Popen([sys.executable, "-m", "vegrip", "launch", "launch.toml"])
    try:
        margin = first_margin("left")
        assert 0.0 < margin.margin.value < 1.0
        assert margin.lower_bound < margin.margin.value
        end = time.monotonic() + PATIENCE
        while not any(one.arbitration_id == SET_GRIP and any(one.data[:4]) for one in gripper.heard):
            assert time.monotonic() < end
            time.sleep(0.05)
    finally:
        process.send_signal(2)
        process.wait(60)


def first_margin(finger: str) -> SlipMargin:
    """Wait for a valid margin of a contact that is loaded and holds, as a monitor hears it."""
    end = time.monotonic() + PATIENCE
    reader = None
    while time.monotonic() < end:
        if reader is None:
            try:
                reader = TelemetryReader([find_node("grasp_force")])
            except Exception:  # noqa: BLE001 (not there yet)
                time.sleep(0.1)
                continue
        for _, _, direction, message in reader.read(0.2):
            is_ours = isinstance(message, SlipMargin) and direction == "out" and message.finger == finger
            if is_ours and message.margin.valid and 0.0 < message.lower_bound < message.margin.value < 0.95:
                reader.close()
                return message
    raise AssertionError("no margin came")
