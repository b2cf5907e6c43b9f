"""Starts the nodes of a launch file as processes, in order; watches over them; stops them in reverse.

Each child leads a process group of its own, so that a Ctrl-C in the terminal reaches the launcher alone and
the order is kept. A child ends when the launcher dies (:func:`end_with_parent`).
"""

import ctypes
import os
import signal
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from vegrip.clock import NS, Clock
from vegrip.errors import DeviceError

FIRST_DELAY = 1.0  # [s]
LAST_DELAY = 30.0  # [s] it doubles up to this
STEADY_RUN_S = 60.0  # [s] a node that ran as long begins with the first delay again


class RestartPolicy:
    """One node's ``restart``: never, on-failure or always."""

    def __init__(self, when: str) -> None:
        self._when = when
        self._delay = FIRST_DELAY
        self.failures = 0
        """How often in a row it ended soon with an error, which it says itself."""

    def delay(self, exit_code: int, ran: float) -> float | None:
        """Return the wait [s] before a node that ``ran`` so long [s] starts again; None: it does not."""
        if self._when == "never" or (self._when == "on-failure" and exit_code == 0):
            return None
        if ran >= STEADY_RUN_S:
            self._delay = FIRST_DELAY
        self.failures = self.failures + 1 if exit_code > 0 and ran < STEADY_RUN_S else 0
        delay, self._delay = self._delay, min(2 * self._delay, LAST_DELAY)
        return delay


class Sayings:
    """What a node says, but for what it has said in a row of failures: why it cannot start is said once."""

    def __init__(self) -> None:
        self._before: set[str] = set()
        self._now: set[str] = set()

    def begin(self, *, again: bool) -> None:
        """Begin a run; ``again``: after a failure, whose sentences are not said again."""
        self._before, self._now = self._now if again else set(), set()

    def is_new(self, line: str) -> bool:
        self._now.add(line)
        return line not in self._before


PROCESS_POLL_S = 0.05  # [s] between two looks at the processes
GRACE = 5.0  # [s] for a node to end before it is killed
EXIT_LOST = DeviceError.exit_code  # of a node that could not keep what it was given
_PR_SET_PDEATHSIG = 1  # linux/prctl.h


Process = subprocess.Popen[str]
Start = Callable[[], Process]


@dataclass
class ChildProcess:
    """One node of the launch file."""

    name: str
    start: Start
    restart: str = "never"
    required: bool = False
    ready: Callable[[], bool] | None = None  # asked before the next child is started
    sayings: Sayings = field(default_factory=Sayings)
    process: Process | None = None
    policy: RestartPolicy = field(init=False)
    started: int = 0  # [ns]
    again_at: int | None = None  # [ns] when it will be started again

    def __post_init__(self) -> None:
        self.policy = RestartPolicy(self.restart)


class Launcher:
    """Watches over children."""

    def __init__(
        self, children: Sequence[ChildProcess], clock: Clock, say: Callable[[str, str], None]
    ) -> None:
        self._children = children
        self._clock = clock
        self._say = say
        self._stop = False
        self.exit_code = 0  # of the first child that ended badly for good

    def run(self) -> int:
        """Start all, watch until everything has ended, and return the exit code."""
        try:
            if all(self._brought_up(child) for child in self._children):
                while self._watched():
                    pass
        finally:
            self.stop_all()
        return self.exit_code

    def stop(self) -> None:
        """End soon; may be called from a signal handler."""
        self._stop = True

    def step(self) -> bool:
        """Look at every child once; return whether there is anything left to watch."""
        for child in self._children:
            if child.process is not None:
                code = child.process.poll()
                if code is not None and not self._ended(child, code):
                    return False
            elif child.again_at is not None and self._clock.now() >= child.again_at:
                self._start(child)
        return any(child.process is not None or child.again_at is not None for child in self._children)

    def stop_all(self) -> None:
        for child in reversed(self._children):
            child.again_at = None
            if child.process is not None:
                self._stop_one(child, child.process)

    def _brought_up(self, child: ChildProcess) -> bool:
        self._start(child)
        while child.ready is not None and child.process is not None and not child.ready():
            if not self._watched():
                return False
        return not self._stop

    def _watched(self) -> bool:
        if self._stop or not self.step():
            return False
        self._clock.sleep_until(self._clock.now() + round(PROCESS_POLL_S * NS))
        return not self._stop

    def _start(self, child: ChildProcess) -> None:
        is_retry = child.policy.failures > 0
        child.sayings.begin(again=is_retry)
        child.process, child.started, child.again_at = child.start(), self._clock.now(), None
        if not is_retry:
            self._say(child.name, "started")

    def _ended(self, child: ChildProcess, code: int) -> bool:
        child.process = None
        delay = child.policy.delay(code, (self._clock.now() - child.started) / NS)
        if delay is not None:
            times = child.policy.failures
            if times & (times - 1) == 0:  # 1, 2, 4, 8, ...
                often = f", {times} times in a row" if times > 1 else ""
                self._say(child.name, f"ended with {_words(code)}{often}; starts again in {delay:g} s")
            child.again_at = self._clock.now() + round(delay * NS)
            return True
        self._say(child.name, f"ended with {_words(code)}" + ("; it is required" if child.required else ""))
        self.exit_code = self.exit_code or (128 - code if code < 0 else code)
        return not child.required

    def _stop_one(self, child: ChildProcess, process: Process) -> None:
        if process.poll() is None:
            process.terminate()
            try:
                process.wait(GRACE)
            except subprocess.TimeoutExpired:
                self._say(child.name, f"did not end within {GRACE:g} s and was killed")
                process.kill()
                process.wait()
        code, child.process = process.poll(), None
        if code == EXIT_LOST:
            self._say(child.name, f"stopped with {_words(code)}")
            self.exit_code = self.exit_code or code
            return
        self._say(child.name, "stopped")


def end_with_parent(parent: int | None = None) -> None:
    """Ask the kernel to send this process SIGTERM when its parent dies; at once where it has died already."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if parent is not None and os.getppid() != parent:
        signal.raise_signal(signal.SIGTERM)


def _words(code: int) -> str:
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
