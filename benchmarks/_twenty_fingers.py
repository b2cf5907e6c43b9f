"""Twenty fingers at 1 kHz over the batch link: what one node takes of a core, and how late its commands are.

A child plays the states of a recorded hand, one batch each millisecond; the node runs in this process, with
its reports, and with a real-time priority where that is permitted. Commands are timed where they are wanted:
from a batch handed to the link to the commands received from it.

Before and after the node an echo answers the same player over the same link, half as long each time: what
waking and handing over take on this machine just then. A p99 is to be read beside that of the echo.
"""

import multiprocessing
import select
import tempfile
import time
from collections import deque
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import zmq

from benchmarks._latency_feed import CHANNELS, record
from benchmarks._nodes import private_runtime
from vegrip.clock import NS, WallClock
from vegrip.grip.frame_path import BatchPath
from vegrip.host.realtime import HAND_PRIORITY, NODE_PRIORITY, priority_of
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.runtime.statistics import Histogram
from vegrip.transport.codec.batch_codec import FIRST_ROW, BatchCodec
from vegrip.transport.curve import resolve
from vegrip.transport.open import Hand, open_endpoint
from vegrip.transport.zmq_endpoint import BatchEndpoint
from vegrip.trials.candidates import demo_parameters, make_node

FINGERS = 20
RATE = 1000  # [Hz]
WARM = 1.5  # [s]
NAMES = ("thumb", *(f"finger{number}" for number in range(1, FINGERS)))
ROWS_AT = FIRST_ROW - 3
TAIL_NS = 50_000_000  # [ns] for the last answers
HAND, GRIP = "ipc:hand", "ipc:grip"
ECHO_WAIT_S = 0.01
LIFETIME = 100_000_000  # [ns]
ANSWERED = bytes([1]) * FINGERS


@dataclass(frozen=True)
class Heard:
    """What came back to the player."""

    batches: int
    commands: int
    latency: Histogram  # of batches


@dataclass(frozen=True)
class Served:
    """What one who answers took of a core, and how late its answers were."""

    cores: float
    rows_per_s: float
    heard: Heard


class Answers(Protocol):
    """One who answers batches of states."""

    @property
    def rows(self) -> int:
        """States answered so far."""

    def start(self) -> None:
        """Be ready to answer, with the priority of a node."""

    def step(self) -> None:
        """Wait for a batch or the next tick, and serve it."""

    def close(self) -> None:
        """Answer no more."""


class Gripping:
    """The node with its loop and its reports."""

    def __init__(self) -> None:
        self._endpoint = open_batches()
        self._priority = priority_of(NODE_PRIORITY)
        node = make_node(demo_parameters(), NAMES)
        loop = LoopSettings(tick_period=0.01)
        self.runner = Runner(node, self._endpoint, WallClock(), loop, priority=self._priority)

    @property
    def rows(self) -> int:
        """States answered so far."""
        assert isinstance(self.runner.frame_path, BatchPath)
        return self.runner.frame_path.frames

    def start(self) -> None:
        """Configure and activate the node."""
        self.runner.start()

    def step(self) -> None:
        """Let the loop wait and serve."""
        self.runner.step()

    def close(self) -> None:
        """Close the sockets."""
        self._priority.give_back()
        self._endpoint.close()


class Echoing:
    """Answers a batch at once with as many commands, of which nothing is worked out: the link alone."""

    def __init__(self) -> None:
        self.rows = 0
        self._endpoint = open_batches()
        self._priority = priority_of(NODE_PRIORITY)
        self._endpoint.intercept_batch = self._answer
        codec = BatchCodec(NAMES)
        frames = [
            codec.encode(ForceCommand(1, name, 0, 1.0, 0.0, Reason.HOLD, LIFETIME))[0] for name in NAMES
        ]
        self._commands = codec.pack(ForceCommand, frames)

    def start(self) -> None:
        """Take the priority of a node."""
        self._priority.take()

    def step(self) -> None:
        """Wait for a tick at most, and answer meanwhile."""
        self._endpoint.receive(ECHO_WAIT_S)

    def close(self) -> None:
        """Close the sockets."""
        self._priority.give_back()
        self._endpoint.close()

    def _answer(self, payload: bytes, rows: int, arrival: int) -> bytes:  # noqa: ARG002
        end = FIRST_ROW + rows * (len(self._commands) - FIRST_ROW) // FINGERS
        commands = self._commands[:end]
        self._endpoint.batches.seal(commands, ForceCommand, rows)
        self._endpoint.send_batch(ForceCommand, commands)
        self.rows += rows
        return ANSWERED[:rows]


def measure(seconds: float) -> dict[str, float]:
    """Return shares of a core and latencies [us], those of an echo before and after beside the node's."""
    with ExitStack() as stack:
        stack.enter_context(private_runtime())
        states = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "states.npy"
        record(states)
        before = served(Echoing(), states, seconds / 2)
        node = Gripping()
        gripped = served(node, states, seconds)
        after = served(Echoing(), states, seconds / 2)
    latency, echoed = gripped.heard.latency, Histogram.sum_of([before.heard.latency, after.heard.latency])
    return {
        "cores": gripped.cores,
        "states_per_s": gripped.rows_per_s,
        "p50_us": latency.percentile(0.5) / 1e3,
        "p99_us": latency.percentile(0.99) / 1e3,
        "unanswered": float(gripped.heard.batches - latency.count),
        "reports_lowered": float(node.runner.statistics.pace.lowered),
        "echo_cores": (before.cores + after.cores) / 2.0,
        "echo_p50_us": echoed.percentile(0.5) / 1e3,
        "echo_p99_us": echoed.percentile(0.99) / 1e3,
    }


def open_batches() -> BatchEndpoint:
    """Return the link of one who answers."""
    table = {"kind": "zmq", "batch": True, "publish": GRIP, "subscribe": (HAND,), "sender_time": False}
    endpoint = open_endpoint(table, Hand(NAMES))
    assert isinstance(endpoint, BatchEndpoint)
    return endpoint


def served(answers: Answers, states: Path, seconds: float) -> Served:
    """Let a player send ``states`` to ``answers`` for ``seconds``."""
    with closing(answers):
        context = multiprocessing.get_context("spawn")
        pipe, theirs = context.Pipe()
        child = context.Process(target=play, args=(theirs, states, seconds), daemon=True)
        child.start()  # before this process has a priority, which threads of the child would inherit
        theirs.close()
        pipe.recv()
        answers.start()
        pipe.send("begin")
        return _timed(answers, pipe, seconds)


def _timed(answers: Answers, pipe: Connection, seconds: float) -> Served:
    while not answers.rows and not pipe.poll():  # a player that has died has closed its end
        answers.step()
    warm = time.monotonic() + WARM / 2
    while time.monotonic() < warm:
        answers.step()
    start, taken, rows = time.monotonic(), time.process_time(), answers.rows
    while time.monotonic() < start + seconds:
        answers.step()
    elapsed, taken = time.monotonic() - start, time.process_time() - taken
    rows = answers.rows - rows
    while not pipe.poll():
        answers.step()
    return Served(taken / elapsed, rows / elapsed, pipe.recv())


def play(pipe: Connection, states: Path, seconds: float) -> None:
    """Send a batch each millisecond, and time what comes back; runs in a process of its own."""
    payloads = batches(np.load(states), round((WARM + seconds) * RATE))
    topics = BatchCodec(NAMES).topics
    context = zmq.Context()
    sender, receiver = context.socket(zmq.PUB), context.socket(zmq.SUB)
    sender.bind(resolve(HAND))
    receiver.connect(resolve(GRIP))
    receiver.subscribe("/hand/force_commands")
    pipe.send("ready")
    pipe.recv()
    # until those who publish and subscribe have met; and ZeroMQ ends a program whose priority changes while
    # its threads ask for it
    time.sleep(0.5)
    priority_of(HAND_PRIORITY).take()
    latency, commands = Histogram(), 0
    under_way: deque[int] = deque()  # [ns] when the batches left that are not answered yet
    due = time.monotonic_ns()
    for number, payload in enumerate(payloads):
        due += NS // RATE
        commands += _hear_until(due, receiver, under_way, latency if number > WARM * RATE else Histogram())
        if number == WARM * RATE:  # what was lost before the sockets had met is not waited for
            due += TAIL_NS
            _hear_until(due, receiver, under_way, Histogram())
            under_way.clear()
        under_way.append(time.monotonic_ns())
        sender.send_multipart([topics[FingertipState].encode(), payload])
    commands += _hear_until(due + TAIL_NS, receiver, under_way, latency)
    pipe.send(Heard(round(seconds * RATE), commands, latency))
    context.destroy(linger=0)


def _hear_until(due: int, receiver: Any, under_way: deque[int], latency: Histogram) -> int:
    """Take answers until ``due`` [ns]; return the commands."""
    commands = 0
    while (left := due - time.monotonic_ns()) > 0:
        if receiver.getsockopt(zmq.EVENTS) & zmq.POLLIN:
            commands += _take(receiver, under_way, latency)
        else:
            select.select([receiver], [], [], left / NS)
    return commands


def _take(receiver: Any, under_way: deque[int], latency: Histogram) -> int:
    """Take the answers that are there; the node answers batches in their order. Return the commands."""
    rows = 0
    with suppress(zmq.Again):
        while True:
            rows += receiver.recv_multipart(zmq.DONTWAIT)[1][ROWS_AT]
            if under_way:
                latency.add(time.monotonic_ns() - under_way.popleft())
    return rows


def batches(rows: Any, count: int) -> list[bytes]:
    """Return so many batches of the recorded states: five fingers, again and again."""
    codec, found = BatchCodec(NAMES), []
    for seq in range(count):
        row = rows[seq % len(rows)]
        states = [
            FingertipState(1, name, seq, **dict(zip(CHANNELS, row[number % len(row)].tolist(), strict=True)))
            for number, name in enumerate(NAMES)
        ]
        frames = [frame for state in states for frame in codec.encode(state)]
        found.append(bytes(codec.pack(FingertipState, frames)))
    return found
