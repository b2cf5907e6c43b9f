"""A node of the demonstration in a process of its own, tied to its parent by a pipe.

The child says ``("ready", None)`` once it is configured, starts when asked, streams news if its node has any,
and ends with ``("done", RunStatistics)``. When the pipe breaks because the parent has gone it stops: no
orphans.
"""

import math
import multiprocessing
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from typing import Any, cast

from vegrip.clock import WallClock
from vegrip.demo.product import CopyingEndpoint
from vegrip.errors import DeviceError, VegripError
from vegrip.host.realtime import priority_of
from vegrip.messages import Message
from vegrip.nodes.virtual_hand import Parameters, VirtualHandNode
from vegrip.runtime.node import NodeBase
from vegrip.runtime.process import SWITCH_INTERVAL
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.open import Hand, open_endpoint
from vegrip.trials.closed_loop import Course, Scenario
from vegrip.virtual import VirtualHand

SAMPLING = 0.01  # [s] of the truth


@dataclass(frozen=True, slots=True)
class HandNews:
    """How the object is doing."""

    time: float  # [s] simulated
    slips: int
    dropped: bool
    acting: tuple[str, ...]  # names of the disturbances that act now


class DemoHand(VirtualHandNode):
    """A virtual hand that goes through a scenario and keeps the truth of it."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.course = Course(scenario.settings.fingers)
        settings = replace(
            Parameters(), hand=scenario.settings, seed=scenario.seed, duration=scenario.duration
        )
        super().__init__("virtual_hand", settings)

    def configure(self) -> None:
        super().configure()
        self.new_hand().truths()

    def on_tick(self, now: int) -> Iterable[Message]:
        """Simulate up to now, and note the truth."""
        states = super().on_tick(now)
        if self.hand.time >= len(self.course.time) * SAMPLING and not self.hand.dropped:
            asked = (self.commands.get(finger) for finger in self.hand.fingers)
            forces = [math.nan if one is None else one.normal_force for one in asked]
            self.course.sample(self.hand, forces)
        self.finished = self.finished or self.hand.dropped
        return states

    def news(self) -> HandNews:
        time = self.hand.time
        acting = tuple(
            type(event).__name__
            for event in self.hand.events
            if event.start < time < event.start + event.duration
        )
        return HandNews(time, self.hand.slips, self.hand.dropped, acting)

    def rest(self) -> Any:
        self.course.finish(self.hand)
        return self.course

    def new_hand(self) -> VirtualHand:
        return self.scenario.hand()


NEWS_PERIOD = 0.1  # [s]


@dataclass(frozen=True)
class Job:
    """What a child is to run."""

    build: Callable[..., NodeBase]
    arguments: tuple[Any, ...]
    transport: Mapping[str, Any]
    fingers: tuple[str, ...]
    tick_period: float  # [s]
    copy_to: Mapping[str, Any] | None = None  # transport of a bus where all is to be seen besides


@dataclass(frozen=True)
class RunStatistics:
    """What a node has done when it ends."""

    states: int
    commands: int
    deadline_misses: int
    latency_p50: float  # [us]
    latency_p99: float  # [us]
    latency_max: float  # [us]
    rejected: Mapping[str, int]
    rest: Any  # what the node itself has to report


def serve(pipe: Connection, job: Job) -> None:
    """Run ``job``; the main function of the child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent decides
    try:
        _run(pipe, job)
    except VegripError as error:
        pipe.send(("error", str(error)))
    except (BrokenPipeError, EOFError):
        sys.exit(1)
    except Exception as error:  # noqa: BLE001 (a mistake of ours, reported in one sentence like the others)
        pipe.send(("error", f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"))


def _run(pipe: Connection, job: Job) -> None:
    sys.setswitchinterval(SWITCH_INTERVAL)
    node = job.build(*job.arguments)
    endpoint = open_endpoint(job.transport, Hand(job.fingers))
    if job.copy_to is not None:
        endpoint = CopyingEndpoint(endpoint, open_endpoint(job.copy_to, Hand(job.fingers)))
    priority = priority_of(node.realtime_priority)
    try:
        settings = LoopSettings(tick_period=job.tick_period)
        runner = Runner(node, endpoint, WallClock(), settings, priority=priority)
        runner.change("configure")
        pipe.send(("ready", None))
        if pipe.recv() != "start":
            return
        over = threading.Event()
        talk = threading.Thread(target=_report, args=(pipe, runner, over), daemon=True)
        runner.change("activate")
        pipe.send(("active", None))
        talk.start()
        priority.take()  # again, for the thread that has just begun
        runner.run()
        over.set()
        talk.join()
        pipe.send(("done", _run_statistics(runner)))
    finally:
        endpoint.close()


def _report(pipe: Connection, runner: Runner, over: threading.Event) -> None:
    """Pass news on, and stop the loop when the parent says so or has gone."""
    node = runner.managed.node
    try:
        while not over.is_set():
            if pipe.poll(NEWS_PERIOD):
                pipe.recv()
                runner.stop()
            elif hasattr(node, "news"):
                pipe.send(("news", cast("Any", node).news()))
    except (EOFError, OSError):
        runner.stop()


def _run_statistics(runner: Runner) -> RunStatistics:
    statistics, node = runner.statistics, runner.managed.node
    latency = statistics.latency
    return RunStatistics(
        states=statistics.states,
        commands=statistics.commands,
        deadline_misses=statistics.deadline_misses,
        latency_p50=latency.percentile(0.50) / 1e3,
        latency_p99=latency.percentile(0.99) / 1e3,
        latency_max=latency.maximum / 1e3,
        rejected=dict(runner.status.rejected) if runner.status is not None else {},
        rest=cast("Any", node).rest() if hasattr(node, "rest") else None,
    )


START_PATIENCE = (
    600.0  # [s] a first run compiles, a busy machine compiles slowly; a dead child is seen at once
)
END_PATIENCE = 10.0  # [s]


class WorkerHandle:
    """A node in a process of its own."""

    def __init__(self, name: str, job: Job) -> None:
        self.name = name
        self.news: Any = None  # the newest
        self.statistics_at_end: RunStatistics | None = None
        self._said: set[str] = set()
        context = multiprocessing.get_context("spawn")  # a fork would inherit the bus and its threads
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs, job), name=name, daemon=True)
        self._process.start()
        theirs.close()

    @property
    def process_id(self) -> int:
        return self._process.pid or 0

    def wait(self, word: str) -> None:
        """Wait until the child says ``word``."""
        deadline = time.monotonic() + START_PATIENCE
        while time.monotonic() < deadline:
            if word in self._said:
                return
            if self._pipe.poll(0.1):
                self._said.add(self._receive())
        raise DeviceError(f"the process of {self.name} does not get ready within {START_PATIENCE:g} s")

    def say(self, word: str) -> None:
        """Send the child something; one that has gone does not receive it."""
        try:
            self._pipe.send(word)
        except (BrokenPipeError, OSError):
            return

    def listen(self) -> bool:
        """Take in what the child has said; return whether it still runs."""
        while self.statistics_at_end is None and self._pipe.poll():
            self._receive()
        return self.statistics_at_end is None

    def stop(self) -> None:
        """Ask the child to end, and see that it does."""
        self.say("stop")
        deadline = time.monotonic() + END_PATIENCE
        try:
            while self.statistics_at_end is None and time.monotonic() < deadline:
                if self._pipe.poll(0.05):
                    self._receive()
        except DeviceError:
            pass  # it has ended in another way
        self._process.join(1.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()

    def _receive(self) -> str:
        try:
            word, content = self._pipe.recv()
        except (EOFError, OSError):
            raise DeviceError(f"the process of {self.name} has ended unexpectedly") from None
        if word == "error":
            raise DeviceError(f"{self.name}: {content}")
        if word == "news":
            self.news = content
        if word == "done":
            self.statistics_at_end = content
        return str(word)
