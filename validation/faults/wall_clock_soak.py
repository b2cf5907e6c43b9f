"""Minutes of holding by real processes on the wall clock, with one accident after another.

What the simulated soak cannot see: memory, descriptors and threads of each process, real signals, the process
of the bus, sockets of those who died.
"""

import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any
from unittest import mock

import can

from vegrip.host.folders import socket_path
from vegrip.messages import FingertipState, ForceCommand
from vegrip.runtime.registry import find_node, running_nodes
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint

CHANNEL = "soak"
FINGERS = ("thumb", "index")
LAUNCH = f"""
fingers = ["thumb", "index"]

[transport]
channel = "{CHANNEL}"

[[node]]
program = "grasp_force"
wait = true
restart = "always"
loop.tick_period = 0.005

[[node]]
program = "virtual_hand"
required = true
loop.tick_period = 0.005
[node.parameters]
disturbed = false
hand.fingers = ["thumb", "index"]
hand.x = [0.0, 0.0]
hand.y = [0.0, 0.0]
hand.plate.mass = 0.1
hand.sensor.rate = 200.0
hand.actuator.close_time = 5.0

[[node]]
program = "record"
restart = "always"
loop.tick_period = 0.1
"""
START_TIMEOUT_S = 120.0  # [s] at most until the grip is held
SETTLE_S = 10.0  # [s] then, before anything is judged
ACCIDENT_PAUSE_S = 3.0  # [s] between two accidents
LOST_FORCE_N = 0.2  # [N] a finger that measures less has lost the object
RECOVERY_TIMEOUT_S = (
    15.0  # [s] within which all fingers are commanded again; a restart waits 1 s and imports for some
)
DEADLY = 0.3  # share of the time in which processes are killed; later on each is watched for growth
MEGABYTE = 1e6
STEEP = 1.0  # [MB/min] of resident memory, beyond which it is a leak
YOUNG = 60.0  # [s] of life, in which caches and bounded memories fill
MORE = 2  # descriptors or threads; what is open for a moment


@dataclass
class Footprint:
    """What one process used, second by second."""

    name: str
    time: list[float] = field(default_factory=list)  # [s]
    memory: list[int] = field(default_factory=list)  # [bytes] resident
    descriptors: list[int] = field(default_factory=list)
    threads: list[int] = field(default_factory=list)

    def look(self, pid: int) -> None:
        """Note what ``pid`` uses now; one that has ended is left as it was."""
        process = Path(f"/proc/{pid}")
        try:
            pages = int((process / "statm").read_text(encoding="ascii").split()[1])
            open_now, threads = len(list((process / "fd").iterdir())), len(list((process / "task").iterdir()))
        except OSError:
            return
        self.time.append(time.monotonic())
        self.memory.append(pages * os.sysconf("SC_PAGE_SIZE"))
        self.descriptors.append(open_now)
        self.threads.append(threads)

    @property
    def growth(self) -> float:
        """Slope of the memory over the second half of the life [MB/min]; 0 of a life too short to tell."""
        half = len(self.time) // 2
        if self.time[-1] - self.time[0] < YOUNG:
            return 0.0
        slope = statistics.linear_regression(self.time[half:], self.memory[half:]).slope
        return slope * 60.0 / MEGABYTE

    def complaints(self) -> Iterator[str]:
        """Yield what has grown."""
        count = len(self.time)
        if self.growth > STEEP:
            yield f"{self.name} grows by {self.growth:.1f} MB/min"
        for what, counts in (("descriptors", self.descriptors), ("threads", self.threads)):
            before, after = max(counts[: count // 2], default=0), min(counts[count * 3 // 4 :])
            if count > YOUNG and after > before + MORE:
                yield f"{self.name} has {after} {what}, and had {before}"


@dataclass
class WallSoak:
    """What happened."""

    duration: float = 0.0  # [s]
    accidents: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    slowest_recovery: float = 0.0  # [s] until all fingers were commanded again
    least_grip: float = float("inf")  # [N] as measured
    footprints: dict[int, Footprint] = field(default_factory=dict)  # by process number
    complaints: list[str] = field(default_factory=list)


def wall_soak(duration: float, seed: int = 0, progress: Callable[[str], object] | None = None) -> WallSoak:
    """Hold for ``duration`` [s] with a random accident every few seconds."""
    with _launched() as launcher, closing(_watcher()) as watcher:
        soak = _Soak(launcher.pid, watcher, Random(seed), progress or (lambda _: None))  # noqa: S311
        soak.run(duration)
    found = soak.result
    for footprint in found.footprints.values():
        found.complaints += footprint.complaints()
    return found


class _Soak:
    def __init__(
        self, launcher: int, watcher: Endpoint, random: Random, progress: Callable[[str], object]
    ) -> None:
        self.result = WallSoak()
        self._launcher, self._watcher, self._random, self._progress = launcher, watcher, random, progress
        self._looked = 0.0
        self._judging = False

    def run(self, duration: float) -> None:
        self._watch_until_commanded(START_TIMEOUT_S)
        self._watch(SETTLE_S)
        self._judging = True
        start = time.monotonic()
        while (elapsed := time.monotonic() - start) < duration and not self.result.complaints:
            names = [*GENTLE, *DEADLY_ONES] if elapsed < DEADLY * duration else [*GENTLE]
            name = self._random.choice(names)
            self._progress(f"{elapsed:6.0f} s  {name}")
            with (GENTLE | DEADLY_ONES)[name]():
                self._watch(0.5)
            self.result.accidents[name] += 1
            took = self._watch_until_commanded(RECOVERY_TIMEOUT_S)
            if took is None:
                self.result.complaints.append(f"no commands {RECOVERY_TIMEOUT_S:g} s after {name}")
            self.result.slowest_recovery = max(self.result.slowest_recovery, took or 0.0)
            self._watch(ACCIDENT_PAUSE_S)
        self.result.duration = time.monotonic() - start
        if self.result.least_grip < LOST_FORCE_N:
            self.result.complaints.append("the object was dropped")

    def _watch_until_commanded(self, patience: float) -> float | None:
        """Return how long it took until every finger has had a new command; None: too long."""
        start = time.monotonic()
        missing = set(FINGERS)
        while time.monotonic() < start + patience:
            missing -= self._look_at_bus()
            if not missing:
                return time.monotonic() - start
        return None

    def _watch(self, seconds: float) -> None:
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            self._look_at_bus()

    def _look_at_bus(self) -> set[str]:
        """Return the fingers that were commanded."""
        commanded = set()
        for message in self._watcher.receive(0.1):
            if isinstance(message, ForceCommand) and message.normal_force > 0.0:
                commanded.add(message.finger)
            elif isinstance(message, FingertipState) and self._judging:
                self.result.least_grip = min(self.result.least_grip, message.normal_force)
        if time.monotonic() - self._looked > 1.0:
            self._looked = time.monotonic()
            self._look_at_processes()
        return commanded

    def _look_at_processes(self) -> None:
        processes = {entry.pid: entry.name for entry in running_nodes()}
        processes |= {self._launcher: "launcher", os.getpid(): "watcher", _hub(): "bus"}
        for pid, name in processes.items():
            self.result.footprints.setdefault(pid, Footprint(name)).look(pid)


# --- accidents


@contextmanager
def _killed(name: str) -> Iterator[None]:
    os.kill(find_node(name).pid, signal.SIGKILL)
    yield


@contextmanager
def _bus_killed() -> Iterator[None]:
    os.kill(_hub(), signal.SIGKILL)
    yield


@contextmanager
def _stopped() -> Iterator[None]:
    pid = find_node("grasp_force").pid
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


@contextmanager
def _member(**faults: Any) -> Iterator[None]:
    with can.Bus(interface="vegrip", channel=CHANNEL, fd=True, faults=faults):
        yield


@contextmanager
def _subscriber_killed() -> Iterator[None]:
    command = [sys.executable, "-m", "vegrip", "topic", "echo", "/hand", "--json"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as subscriber:
        time.sleep(2.0)
        subscriber.kill()
        yield


Accident = Callable[[], Any]

GENTLE: dict[str, Accident] = {
    "a node babbles": lambda: _member(babble=0),
    "a node misreads": lambda: _member(misreading=0.1),
    "the gripping node stopped": _stopped,
    "a subscriber killed": _subscriber_killed,
}
DEADLY_ONES: dict[str, Accident] = {
    "the gripping node killed": lambda: _killed("grasp_force"),
    "the recorder killed": lambda: _killed("record"),
    "the bus killed": _bus_killed,
}


# --- who is there


@contextmanager
def _launched() -> Iterator[subprocess.Popen[bytes]]:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="vg-")))
        stack.enter_context(mock.patch.dict(os.environ, VEGRIP_RUNTIME_DIR=str(folder / "r")))
        file = folder / "soak.toml"
        file.write_text(LAUNCH, encoding="utf-8")
        command = [sys.executable, "-m", "vegrip", "launch", str(file)]
        launcher = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            yield launcher
        finally:
            launcher.send_signal(signal.SIGINT)
            launcher.wait()


def _watcher() -> Endpoint:
    return open_endpoint({"kind": "can", "channel": CHANNEL}, Hand(FINGERS))


def _hub() -> int:
    return int(socket_path("can", f"{CHANNEL}.lock").read_text(encoding="ascii"))
