"""What the virtual CAN bus costs beside what has no arbitration, no bit rate and no errors.

* A frame through the model of the bus, on a simulated clock, against python-can's ``virtual`` from send to
  receive.
* A frame from the bytes of its request to those of its deliveries, the bus in C against the same in Python:
  in a loop, and after a sleep of 1.5 ms, as the bus process runs, when the caches are cold.
* Processor time of the hub per frame, four members on the wall clock, against a process that copies every
  packet to the other members and does nothing else, and against the hub without its compiled loop.
"""

import json
import math
import select
import socket
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from ctypes import addressof, memmove
from itertools import cycle
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random
from statistics import median
from typing import Any

import can

from benchmarks._timing import compared
from validation.bus_bytes import request_of
from validation.faults.simulated_bus import SimulatedBus
from vegrip.host.compiled_folder import compiler
from vegrip.transport.canbus import carry
from vegrip.transport.canbus.compiled_bus import CompiledBus, Search, compile_library
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame
from vegrip.transport.canbus.hub import AT_ONCE, Hub
from vegrip.transport.canbus.hub_wire import HUB_VERSION, MAX_PACKET_BYTES

PYTHON = carry
MEMBERS = 4
MOST = 1000  # packets taken in one go
FINGERS, PERIOD = 5, 0.002  # [s]
ROUNDS = 1500
ASLEEP = 0.0015  # [s] between two wake-ups of the bus process
TAKES = 200_001  # [ns] longer than any of the frames
SMALLEST = {"ROUNDS": 20}
RANDOM = Random(1)  # noqa: S311 (no secret)
FRAMES = [
    BusFrame(0x200 + i % FINGERS, RANDOM.randbytes(32), fd=True, has_bit_rate_switch=True) for i in range(500)
]


def run() -> dict[str, dict[str, float]]:
    """Measure all."""
    with ExitStack() as stack:
        ends = [
            stack.enter_context(
                can.Bus(interface="virtual", channel="bench", protocol=can.CanProtocol.CAN_FD)
            )
            for _ in range(MEMBERS)
        ]
        model = compared(_through_the_model(), _through_python_can(ends))
    rows = {"bus_model_frame_vs_python_can_virtual": model}
    interpreted, copying = _hub_time(_hub, _greeting()), _hub_time(_copy, b"")
    if compiler() is None:
        return rows | {"hub_cpu_per_frame_vs_copying": _row(interpreted, copying)}
    with _carrier(CompiledBus(compile_library())) as in_c, _carrier(PYTHON) as in_python:
        rows |= {
            "compiled_frame_vs_python": compared(in_c, in_python),
            "compiled_frame_vs_python_after_a_sleep": _row(_after_sleeps(in_c), _after_sleeps(in_python)),
        }
    compiled = _hub_time(_compiled_hub, _greeting())
    return rows | {
        "hub_cpu_per_frame_vs_copying": _row(compiled, copying),
        "hub_cpu_per_frame_vs_hub_in_python": _row(compiled, interpreted),
    }


def _row(ours: float, theirs: float) -> dict[str, float]:
    return {"ours_us": ours, "theirs_us": theirs, "ratio": theirs / ours}


@contextmanager
def _carrier(text: Any) -> Iterator[Callable[[], object]]:
    """Yield what takes a frame from the bytes of its request to those of its deliveries."""
    bus, packets, now = SimulatedBus(BitTiming()), cycle([request_of(0, frame) for frame in FRAMES]), 0
    record = bus.record
    memory = record if text is PYTHON else addressof(record)
    pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(MEMBERS)]
    for number, (ours, _) in enumerate(pairs):
        bus.attach(number)
        bus.node(number).descriptor = ours.fileno()
        bus.node(number).patience = 1 << 40  # gathered and thrown away: what is measured makes no system call
    nodes = [bus.node(number) for number in range(MEMBERS)]

    def carry() -> object:
        nonlocal now
        packet = next(packets)
        memmove(record.packet, packet, len(packet))
        text.take_packet(memory, now & 3, len(packet), now)
        text.advance(memory, now)
        now += TAKES
        while text.advance(memory, now):
            text.bring_events(memory, now)
        for node in nodes:
            node.gathered = 0
        return record

    yield carry
    for pair in pairs:
        for end in pair:
            end.close()


def _after_sleeps(carry: Callable[[], object]) -> float:
    """Return the time [us] of a call after a sleep."""
    times = []
    for _ in range(ROUNDS):
        time.sleep(ASLEEP)
        start = time.perf_counter()
        carry()
        times.append(time.perf_counter() - start)
    return median(times) * 1e6


def _through_the_model() -> Callable[[], object]:
    bus, frames = SimulatedBus(BitTiming()), cycle(FRAMES)
    for node in range(MEMBERS):
        bus.attach(node)
    now = 0

    def send() -> object:
        nonlocal now
        bus.request(now, now & 3, next(frames))
        bus.advance(now)
        now += 200_001
        return bus.advance(now)

    return send


def _through_python_can(ends: list[can.BusABC]) -> Callable[[], object]:
    messages = cycle(
        can.Message(arbitration_id=f.identifier, data=f.data, is_extended_id=False, is_fd=True)
        for f in FRAMES
    )

    def send() -> object:
        ends[0].send(next(messages))
        return [end.recv(0.0) for end in ends[1:]]

    return send


# --- the hub as a process


def _greeting() -> bytes:
    return json.dumps({"version": HUB_VERSION, "timing": {}}).encode()


def _hub(listener: socket.socket) -> None:
    Hub(listener).serve()


def _compiled_hub(listener: socket.socket) -> None:
    Hub(listener, Search()).serve()


def _copy(listener: socket.socket) -> None:
    """Bring every packet to all other members until the last has left."""
    members = [listener.accept()[0] for _ in range(MEMBERS)]
    while members:
        for sender in select.select(members, [], [])[0]:
            try:
                packet = sender.recv(MAX_PACKET_BYTES)
            except ConnectionResetError:  # it left without reading all
                packet = b""
            if not packet:
                members.remove(sender)
            for member in members:
                if packet and member is not sender:
                    with suppress(OSError):  # it does not read, or has left
                        member.send(packet, AT_ONCE)


def _hub_time(serve: Callable[[socket.socket], None], greeting: bytes) -> float:
    """Return the processor time [us] of the process that serves, per frame."""
    with tempfile.TemporaryDirectory(prefix="vg-") as folder, closing(_listener(Path(folder))) as listener:
        ours, theirs = get_context("fork").Pipe()
        process = get_context("fork").Process(target=_timed, args=(serve, listener, theirs))
        process.start()
        with _members(Path(folder), greeting) as members:
            frames = _traffic(members)
        process.join()
        used: float = ours.recv() if ours.poll() else math.nan
    return used / frames * 1e6


def _listener(folder: Path) -> socket.socket:
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    listener.bind(str(folder / "bus"))
    listener.listen(MEMBERS)
    return listener


def _timed(serve: Callable[[socket.socket], None], listener: socket.socket, answer: Connection) -> None:
    start = time.process_time()
    serve(listener)
    answer.send(time.process_time() - start)


@contextmanager
def _members(folder: Path, greeting: bytes) -> Iterator[list[socket.socket]]:
    with ExitStack() as stack:
        members = []
        for _ in range(MEMBERS):
            member = stack.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
            member.connect(str(folder / "bus"))
            if greeting:
                member.send(greeting)
                member.recv(MAX_PACKET_BYTES)
            member.setblocking(False)
            members.append(member)
        yield members


def _traffic(members: list[socket.socket]) -> int:
    """Let the first member send states as fingers do, and the second answer each; return how many frames."""
    sent, due, frames = 0, time.monotonic(), cycle(FRAMES)
    for _ in range(ROUNDS):
        due += PERIOD
        time.sleep(max(due - time.monotonic(), 0.0))
        heard = [_take_all(member) for member in members]
        for member, count in ((members[0], FINGERS), (members[1], heard[1])):
            for _ in range(count):
                select.select([], [member], [])  # a busy machine may leave the hub behind
                member.send(request_of(time.monotonic_ns(), next(frames)))
                sent += 1
    return sent


def _take_all(member: socket.socket) -> int:
    """Receive what is there; return how many packets it was."""
    for count in range(MOST):
        try:
            member.recv(MAX_PACKET_BYTES)
        except BlockingIOError:
            return count
    return MOST
