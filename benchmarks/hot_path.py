"""One finger from frame to frame, compiled: against its physics alone, messages, the loop, and numba.

All on the same recorded frames of a closed loop, in processor time, so that a busy machine does not decide.

* ``finger_step_vs_physics``: the step (checks, watchdog, grip, limits, frames and the physics) against update
  and least force alone, each called from Python;
* ``object_path_vs_finger_step``: codec, node and codec by messages against the step;
* ``loop_vs_finger_step``: the loop of the node, five states at a wake-up, without reports, against the step;
  the ratio is the share of the step;
* ``loop_of_packets_vs_finger_step``: the same where the bus brings the five states in one packet;
* ``object_report_vs_packed``: contact and slip margin as messages to frames, and packed by the step;
* ``wire_fd``, ``wire_classic``, ``wire_canopen``, ``wire_topics``, ``wire_batch``: a state from its bytes to
  those of its command on this wire, codec and node; by messages against as it comes on ``wire_fd`` and
  ``wire_batch``, the others against ``wire_fd``;
* ``wire_map``: the same of a hand of another make behind a map, against ``wire_fd``;
* ``c_vs_numba``: the step by C against the step by numba; every byte and number they make is compared first.

And as cores, on the wall clock, so that what else the machine does counts (with ``load``, the programs that
wanted a core meanwhile):

* ``demo_cores``: all programs of ``vegrip demo --grasp hand``, together and each;
* ``bench_cores``: the same of ``vegrip demo --bench papillarray+robotiq``, two pads and a gripper on lines of
  their own, and how late the node's commands were;
* ``twenty_fingers_core``: a node that answers twenty fingers at 1 kHz over the batch link, and beside it an
  echo (``echo_cores``, ``echo_p50_us``, ``echo_p99_us``), half of its time before and half after.
"""

import contextlib
import itertools
import json
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import can
import numpy as np

from benchmarks._twenty_fingers import measure
from benchmarks._wires import WIRES, require_all_answered, states_of, work
from validation.bus_bytes import delivery_of
from validation.compiled_finger import Log, Replay, record
from validation.faults.simulated_bus import Transmission
from vegrip.c99 import host
from vegrip.clock import WallClock
from vegrip.estimator import ContactEstimator
from vegrip.messages import ForceCommand
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.canbus.frame_time import BusFrame
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.transport.codec import Frame
from vegrip.transport.codec.protection import CAN_PROFILES
from vegrip.trials.candidates import demo_parameters, make_node

SECONDS = 3.0
TURNS = 400
BATCHES = 5
WITH_NUMBA = True
DEMO_SECONDS, TWENTY_SECONDS = 10.0, 5.0
SMALLEST = {
    "SECONDS": 0.5,
    "TURNS": 5,
    "BATCHES": 1,
    "WITH_NUMBA": False,
    "DEMO_SECONDS": 3.0,
    "TWENTY_SECONDS": 0.5,
}

FINGERS = 5
NEVER = (1e6, 1e6)  # [s] between reports
LARGEST = 512  # bytes of a packet
COUNTER_AT, VALUES_AT = 2, 12
COUNTERS: Counter[int] = Counter()
"""By identifier: states that were sent."""
STATE_BYTES = 48
REPORTS = 100  # of each finger
Timed = dict[str, float]
Stated = tuple[Frame, str, int]


def run() -> dict[str, Timed]:
    log = record(None, SECONDS, "hand")
    mode = "c" if host.compiler() is not None else "numba"
    step = finger_step(log, mode)
    results = {
        "finger_step_vs_physics": row(step, physics(log)),
        "object_path_vs_finger_step": row(step, messages(log)),
        "loop_vs_finger_step": row(loop(log, 1), step),
        "loop_of_packets_vs_finger_step": row(loop(log, FINGERS), step),
        "object_report_vs_packed": reports(log),
    }
    results |= {name: wire_row(name, log, mode) for name in WIRES}
    for name in ("wire_classic", "wire_canopen", "wire_topics", "wire_map"):
        results[name] = row(results["wire_fd"]["ours_us"] / 1e6, results[name]["ours_us"] / 1e6)
    if WITH_NUMBA and host.compiler() is not None:
        require_equal(log)
        results["c_vs_numba"] = row(step, finger_step(log, "numba"))
    results["demo_cores"] = demo_cores("--grasp", "hand")
    results["bench_cores"] = demo_cores("--bench", "papillarray+robotiq")
    results["twenty_fingers_core"] = measure(TWENTY_SECONDS) | {"load": os.getloadavg()[0]}
    return results


def demo_cores(*which: str) -> Timed:
    """Return what a demonstration took of the processor, and how late its commands were [us]."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "vegrip", "demo", *which, "--headless", "--json", "--no-plot"]
        command += ["--duration", str(DEMO_SECONDS), "-o", str(Path(folder) / "demo")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(f"vegrip demo: {done.stderr.strip().splitlines()[-1]}")
    told = json.loads(done.stdout)
    late = {"p50_us": told["latency_us"]["p50"], "p99_us": told["latency_us"]["p99"]}
    misses = {"deadline_misses": float(told["deadline_misses"]), "load": os.getloadavg()[0]}
    return {"cores": sum(told["cores"].values()), **told["cores"], **late, **misses}


def row(ours: float, theirs: float) -> Timed:
    return {"ours_us": ours * 1e6, "theirs_us": theirs * 1e6, "ratio": theirs / ours}


def states(replay: Replay) -> list[Stated]:
    """Return the states of a log with their fingers and times."""
    frames = [(event.frame, event.now) for event in replay.log.events if event.frame is not None]
    known = [(frame, now) for frame, now in frames if frame.arbitration_id in replay.lines]
    return [(frame, replay.lines[frame.arbitration_id][0], now) for frame, now in known]


def best(prepare: Callable[[], Callable[[], None]]) -> float:
    """Return the least processor time [s] of what ``prepare`` returns; the first time does not count."""
    taken = []
    for _ in range(BATCHES + 1):
        call = prepare()
        start = time.process_time()
        call()
        taken.append(time.process_time() - start)
    return min(taken[1:])


def finger_step(log: Log, mode: str) -> float:
    """Return the time of a compiled step [s]."""

    def prepare() -> Callable[[], None]:
        replay = Replay(log, mode)
        given, buffer = states(replay), bytearray(64)
        frame, fingers = np.frombuffer(buffer, dtype=np.uint8), replay.node.compiled_fingers
        for finger in fingers.values():
            finger.apply(replace(replay.node.parameters, report_period=NEVER[0], health_period=NEVER[1]))
            finger.take_line()

        def steps() -> None:
            for state, name, now in given:
                buffer[:STATE_BYTES] = state.data
                fingers[name].step(frame, STATE_BYTES, state.stamp, now)

        return steps

    return best(prepare) / len(states(Replay(log, mode)))


def physics(log: Log) -> float:
    """Return the time of update and least force [s]."""

    def prepare() -> Callable[[], None]:
        replay = Replay(log, "c" if host.compiler() is not None else "numba")
        calls, begun = [], set()
        for state, name, _ in states(replay):
            v = struct.unpack_from("<9f", state.data, VALUES_AT)
            estimator = replay.node.fingers[name].estimator
            assert isinstance(estimator, ContactEstimator)
            module, memory = estimator._module, estimator.numbers
            load = float(np.hypot(v[1], v[2]))
            dt = 1.0 / 200.0 if name in begun else -1.0
            begun.add(name)
            calls.append((module, memory, (dt, v[0], v[4], v[8], load, v[3], v[6]), (load, v[3], 0.15, 1.9)))

        def steps() -> None:
            for module, memory, sample, load in calls:
                module.update(memory, *sample)
                module.least_force(memory, *load)

        return steps

    return best(prepare) / len(states(Replay(log, "python")))


def messages(log: Log) -> float:
    """Return the time of a frame that is decoded to a message [s], without reports."""

    def prepare() -> Callable[[], None]:
        replay = Replay(log)
        given = [(event.frame, event.now) for event in log.events if event.frame is not None]

        def steps() -> None:
            for frame, now in given:
                message = replay.codec.decode(frame)
                for answer in replay.node.on_message(message, now) if message is not None else ():
                    if isinstance(answer, ForceCommand):
                        replay.codec.encode(answer)
                        break

        return steps

    return best(prepare) / log.frames


def reports(log: Log) -> Timed:
    """Return how long contact and slip margin take, packed by the step and as messages."""
    replay = Replay(log, "c" if host.compiler() is not None else "numba")
    replay.run()
    node, codec, now = replay.node, replay.codec, log.events[-1].now
    assert node.controller is not None
    for finger in node.fingers.values():
        finger.reports.health(now)  # worked out once for the last state, so not timed below
        finger.apply(replace(node.parameters, report_period=1e-9, health_period=1e6))
        finger.take_line()

    later = itertools.count(now + 1)

    def packed() -> Callable[[], None]:
        def tell() -> None:
            for when in itertools.islice(later, REPORTS):
                for finger in node.compiled_fingers.values():
                    if not finger.numbers.report_as_frames(when):
                        raise AssertionError("the step did not tell its contact")

        return tell

    def as_messages() -> Callable[[], None]:
        def tell() -> None:
            for when in itertools.islice(later, REPORTS):
                for finger in node.fingers.values():
                    codec.encode(finger.reports.contact(when))
                    codec.encode(finger.reports.margin(when))

        return tell

    count = REPORTS * len(log.fingers)
    return row(best(packed) / count, best(as_messages) / count)


def wire_row(name: str, log: Log, mode: str) -> Timed:
    """Return the times of a state on one wire, with and without messages."""
    states = len(states_of(log))
    wire = WIRES[name](log, mode)
    work(wire, compiled=True)()
    require_all_answered(wire, states)
    ours = best(lambda: work(WIRES[name](log, mode), compiled=True))
    theirs = best(lambda: work(WIRES[name](log, ""), compiled=False))
    return row(ours / states, theirs / states)


def loop(log: Log, in_a_packet: int) -> float:
    """Return the time of a state in the loop [s], five at a wake-up, on a socket that is always ready."""
    channel = f"hotpath{time.monotonic_ns()}"
    bus = can.Bus(interface="vegrip", channel=channel, fd=True, patience=0.0)
    assert isinstance(bus, VegripBus)
    bus._socket.close()
    node_end, hub = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    node_end.setblocking(False)
    bus._talk_over(node_end)
    parameters = replace(demo_parameters(), report_period=10.0, health_period=60.0)
    with closing(hub), closing(CanEndpoint(bus, replace(log, sender_time=False).codec())) as endpoint:
        node = make_node(parameters, log.fingers)
        runner = Runner(node, endpoint, WallClock(), LoopSettings(tick_period=10.0, status_period=60.0))
        runner.start()
        runner.step()
        return min(turn_time(runner, hub, packets(log), in_a_packet) for _ in range(BATCHES))


def packets(log: Log) -> Iterator[bytes]:
    """Yield the states of a log over and over, as the bus delivers them now, with counters that go on."""
    replay = Replay(log, "python")
    frames = [frame for frame, _, _ in states(replay)]
    for number in itertools.count():
        frame = frames[number % len(frames)]
        data = bytearray(frame.data)
        struct.pack_into("<I", data, COUNTER_AT, COUNTERS[frame.arbitration_id])
        COUNTERS[frame.arbitration_id] += 1
        CAN_PROFILES["P05"].protect(data, frame.arbitration_id)
        now = time.monotonic_ns()
        sent = Transmission(now, now, 1, BusFrame(frame.arbitration_id, bytes(data), fd=True))
        yield delivery_of(number, sent, 0)


def turn_time(runner: Runner, hub: socket.socket, states: Iterator[bytes], in_a_packet: int) -> float:
    assert runner.frame_path is not None
    path, spent = runner.frame_path, 0.0
    answered = path.frames
    for _ in range(TURNS):
        packets = [b"".join(itertools.islice(states, in_a_packet)) for _ in range(FINGERS // in_a_packet)]
        for packet in packets:
            hub.send(packet)
        start = time.process_time()
        for _ in packets:
            runner.step()
        spent += time.process_time() - start
        with contextlib.suppress(BlockingIOError):
            while hub.recv(LARGEST, socket.MSG_DONTWAIT):
                pass
    frames: int = path.frames - answered
    return spent / max(frames, 1)


def require_equal(log: Log) -> None:
    """Raise unless C and numba make the same bytes and numbers."""
    short = Log(log.fingers, log.sender_time, log.events[: len(log.events) // 4])
    made = {mode: outcome(short, mode) for mode in ("c", "numba")}
    if len(set(made.values())) != 1:
        raise AssertionError("C and numba differ")


def outcome(log: Log, mode: str) -> tuple[bytes, ...]:
    replay = Replay(log, mode)
    commands = b"".join(data for _, data in replay.run().commands)
    memories = [finger.memory for finger in replay.node.compiled_fingers.values()]
    reals = [np.where(np.isnan(memory.f), np.nan, memory.f).tobytes() for memory in memories]
    return (commands, *reals, *[memory.t.tobytes() for memory in memories])
