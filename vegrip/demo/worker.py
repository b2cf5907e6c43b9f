"""A node of the demonstration in a process of its own, tied to its parent by a pipe.

The child says ``("ready", None)`` once it is configured, starts when told, streams news if its node has any,
and ends with ``("done", RunStatistics)``. When the pipe breaks because the parent has gone it stops: no
orphans.
"""

import signal
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Protocol, cast

from vegrip.clock import WallClock
from vegrip.errors import VegripError
from vegrip.host.realtime import priority_of
from vegrip.runtime.node import Node
from vegrip.runtime.process import SWITCH_INTERVAL
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.open import Hand, open_endpoint

NEWS_PERIOD = 0.1  # [s]


@dataclass(frozen=True)
class Job:
    """What a child is to run."""

    build: Callable[..., Node]
    arguments: tuple[Any, ...]
    transport: Mapping[str, Any]
    fingers: tuple[str, ...]
    tick_period: float  # [s]


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
    rest: Any  # what the node itself has to tell


class Reporting(Protocol):
    """A node that reports to its parent process."""

    def news(self) -> Any:
        """Return what is new; called from another thread than the loop's."""

    def rest(self) -> Any:
        """Return what there is to tell at the end."""


def serve(pipe: Connection, job: Job) -> None:
    """Run ``job``; the main function of the child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent decides
    try:
        _run(pipe, job)
    except VegripError as error:
        pipe.send(("error", str(error)))
    except (BrokenPipeError, EOFError):
        sys.exit(1)
    except Exception as error:  # noqa: BLE001 (a mistake of ours, told in one sentence like the others)
        pipe.send(("error", f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"))


def _run(pipe: Connection, job: Job) -> None:
    sys.setswitchinterval(SWITCH_INTERVAL)
    node = job.build(*job.arguments)
    endpoint = open_endpoint(job.transport, Hand(job.fingers))
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
    node = runner.managed.node
    try:
        while not over.is_set():
            if pipe.poll(NEWS_PERIOD):
                pipe.recv()
                runner.stop()
            elif hasattr(node, "news"):
                pipe.send(("news", cast("Reporting", node).news()))
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
        rest=cast("Reporting", node).rest() if hasattr(node, "rest") else None,
    )
