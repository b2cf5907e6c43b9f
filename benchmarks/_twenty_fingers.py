"""Twenty fingers at 1 kHz over the batch link: what one node takes of a core, and how late its commands are.

A child plays the states of a recorded hand, one batch each millisecond; the node runs in this process, with
its reports, and with a real-time priority where that is permitted. Commands are timed where they are wanted:
from a batch handed to the link to the commands received from it.
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
from typing import Any

import numpy as np
import zmq
from vegrip.benchmarks._latency_feed import CHANNELS, record
from vegrip.benchmarks._nodes import private_runtime

from vegrip.clock import NS, WallClock
from vegrip.host.realtime import HAND_PRIORITY, NODE_PRIORITY, priority_of
from vegrip.messages import FingertipState
from vegrip.runtime.batch_path import BatchPath
from vegrip.runtime.histogram import Histogram
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.codec.batch_codec import FIRST_ROW, BatchCodec
from vegrip.transport.open import Hand, open_endpoint
from vegrip.transport.zmq_address import resolve
from vegrip.validation.controllers.candidates import demo_parameters, make_node

FINGERS = 20
RATE = 1000  # [Hz]
WARM = 1.5  # [s]
DEADLINE = 10_000_000  # [ns]
NAMES = ("thumb", *(f"finger{number}" for number in range(1, FINGERS)))
ROWS_AT = FIRST_ROW - 3
TAIL_NS = 50_000_000  # [ns] for the last answers
HAND, GRIP = "ipc:hand", "ipc:grip"


@dataclass(frozen=True)
class Heard:
    """What came back to the player."""

    batches: int
    commands: int
    latency: Histogram  # of batches


def measure(seconds: float) -> dict[str, float]:
    """Return the share of a core, and latencies [us]."""
    with ExitStack() as stack:
        stack.enter_context(private_runtime())
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        record(folder / "states.npy")
        table = {"kind": "zmq", "batch": True, "publish": GRIP, "subscribe": (HAND,), "sender_time": False}
        endpoint = stack.enter_context(closing(open_endpoint(table, Hand(NAMES))))
        node = make_node(demo_parameters(), NAMES)
        runner = Runner(
            node, endpoint, WallClock(), LoopSettings(tick_period=0.01), priority=priority_of(NODE_PRIORITY)
        )
        pipe, theirs = multiprocessing.get_context("spawn").Pipe()
        child = multiprocessing.get_context("spawn").Process(
            target=play, args=(theirs, folder / "states.npy", seconds), daemon=True
        )
        child.start()  # before this process has a priority, which threads of the child would inherit
        theirs.close()
        pipe.recv()
        runner.start()
        pipe.send("begin")
        return _served(runner, pipe, seconds)


def _served(runner: Runner, pipe: Connection, seconds: float) -> dict[str, float]:
    assert isinstance(runner.hot_path, BatchPath)
    while not runner.hot_path.frames and not pipe.poll():  # a player that has died has closed its end
        runner.step()
    warm = time.monotonic() + WARM / 2
    while time.monotonic() < warm:
        runner.step()
    start, taken, rows = time.monotonic(), time.process_time(), runner.hot_path.frames
    while time.monotonic() < start + seconds:
        runner.step()
    elapsed, taken = time.monotonic() - start, time.process_time() - taken
    rows = runner.hot_path.frames - rows
    while not pipe.poll():
        runner.step()
    heard: Heard = pipe.recv()
    return {
        "cores": taken / elapsed,
        "states_per_s": rows / elapsed,
        "p50_us": heard.latency.percentile(0.5) / 1e3,
        "p99_us": heard.latency.percentile(0.99) / 1e3,
        "unanswered": float(heard.batches - heard.latency.count),
        "reports_lowered": float(runner.statistics.pace.lowered),
    }


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
    priority_of(HAND_PRIORITY).take()
    time.sleep(0.5)  # until those who publish and subscribe have met
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
