"""A packet of frames is answered as its frames one by one: the same frames leave, and the same is counted."""

import socket
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from typing import Any

import can
import numpy as np
import pytest

from validation.bus_bytes import delivery_of, split_requests
from validation.compiled_finger import Event, Log
from validation.faults.simulated_bus import Transmission
from vegrip.c99 import host
from vegrip.grip.frame_path import PacketPath
from vegrip.grip.wires import COMMANDED
from vegrip.messages import FingertipState
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.canbus.frame_time import BusFrame
from vegrip.transport.canbus.hub_wire import DELIVERY, MAX_GATHERED_BYTES, PLAIN_FLAGS, RATE_SWITCH
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.trials.candidates import demo_parameters, make_node

pytestmark = pytest.mark.skipif(host.compiler() is None, reason="packets are answered by C")
FINGERS = ("thumb", "index", "middle", "ring", "little")
ROUNDS = 120
Frames = list[tuple[int, bytes]]


def pressing_hand(rounds: int = ROUNDS) -> Log:
    """Return the frames of five fingers that press, 200 Hz, one after the other in every cycle."""
    log, rng = Log(FINGERS), np.random.default_rng(8)
    codec = log.codec()
    for seq in range(rounds):
        depth = 1e-3 * min(seq / 20.0, 1.0)
        for i, finger in enumerate(FINGERS):
            now, noise = 1_000_000_000 + 5_000_000 * seq + 200_000 * i, rng.standard_normal(4)
            force, load = 3e3 * depth + 0.01 * noise[0], 0.4 * depth / 1e-3
            state = FingertipState(
                now, finger, seq, force, load + 0.01 * noise[1], 0.01 * noise[2], 0.0, depth + 5e-6 * noise[3]
            )
            log.events += [Event(now, frame) for frame in codec.encode(state)]
    return log


class StandingClock:
    """A clock that is set."""

    def __init__(self) -> None:
        self.time = 0

    def now(self) -> int:
        return self.time

    def sleep_until(self, time: int) -> None: ...


class Side:
    """A node on a bus whose other end is held by the test."""

    def __init__(self, log: Log, *, packets: bool) -> None:
        parameters = replace(demo_parameters(), report_period=0.02, health_period=0.3)
        bus = can.Bus(interface="vegrip", channel=f"packet{packets:d}", fd=True, patience=0.0)
        assert isinstance(bus, VegripBus)
        bus._socket.close()
        node_end, self.hub = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        node_end.setblocking(False)
        bus._talk_over(node_end)
        self.bus, self.clock = bus, StandingClock()
        self.endpoint = CanEndpoint(bus, log.codec())
        node = make_node(parameters, log.fingers)
        settings = LoopSettings(tick_period=0.01, status_period=60.0, deadline=5.0)  # nothing is late
        self.runner = Runner(node, self.endpoint, self.clock, settings)
        self.clock.time = log.events[0].now
        self.runner.start()
        self.node = node
        if not packets:
            self.endpoint.intercept_packet = None

    def answers(self, packet: bytes, now: int) -> Frames:
        """Return the frames that leave after ``packet`` has come."""
        self.clock.time = now
        self.hub.send(packet)
        for _ in range(9):  # what the first looks leave of a packet
            self.runner._answer_all(self.endpoint.receive(0.0))
        while self.runner._unfinished:
            self.runner._finish_one()
        self.runner._serve_due()
        return list(self._sent())

    def _sent(self) -> Iterator[tuple[int, bytes]]:
        while True:
            try:
                packet = self.hub.recv(MAX_GATHERED_BYTES, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            for _, frame in split_requests(packet):
                yield frame.identifier, frame.data

    def close(self) -> None:
        self.endpoint.close()
        self.hub.close()

    def counts(self) -> tuple[Any, ...]:
        statistics = self.runner.statistics
        lost = {name: n for name, n in self.runner._rejected().items() if name != "reports_lowered"}
        return statistics.states, statistics.commands, statistics.latency.count, self.bus.overruns, lost


def packets(log: Log, seed: int) -> Iterator[tuple[bytes, int]]:
    """Yield packets of the recorded states with their times; some are broken, lost, foreign, twice there."""
    rng, number, busy = np.random.default_rng(seed), 0, 0
    frames = [(event.now, event.frame) for event in log.events if event.frame is not None]
    at = 0
    for _ in range(ROUNDS):
        count = int(rng.integers(1, 8))
        group, at = frames[at : at + count], at + count
        if len(group) < count:
            return
        packet = b""
        for now, frame in group:
            data, identifier = bytearray(frame.data), frame.arbitration_id
            chance = rng.random()
            if seed and chance < 0.02:
                data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
            elif seed and chance < 0.04:
                identifier = int(rng.integers(0x700, 0x800))
            elif seed and chance < 0.05:
                data = data[:12]
            extended = bool(seed) and rng.random() < 0.01
            number += 1 + (bool(seed) and rng.random() < 0.02)
            busy += 100_000
            whole = BusFrame(identifier, bytes(data), extended=extended, fd=True, has_bit_rate_switch=True)
            sent = Transmission(now - 1000, now, 1, whole)
            packet += delivery_of(number, sent, busy)
        if seed and rng.random() < 0.05:
            packet = packet[: int(rng.integers(1, len(packet)))]
        yield packet, group[-1][0]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_packet_is_answered_as_its_frames(seed: int) -> None:
    log = pressing_hand()
    with closing(Side(log, packets=True)) as ours, closing(Side(log, packets=False)) as theirs:
        for packet, now in packets(log, seed):
            mine, others = ours.answers(packet, now), theirs.answers(packet, now)
            assert sorted(mine) == sorted(others)
            assert [f for f in mine if f[0] < 0x100] == [f for f in others if f[0] < 0x100]
        assert ours.counts() == theirs.counts()
        assert ours.counts()[0] > 300
        assert isinstance(ours.runner.frame_path, PacketPath)
        assert ours.runner.frame_path.frames == theirs.runner.frame_path.frames > 300


def changed(piece: bytes, **fields: int) -> bytes:
    """Return a delivery with other fields, or another byte of its data."""
    names = "number", "end", "busy", "node", "identifier", "flags", "code"
    known = dict(zip(names, DELIVERY.unpack_from(piece), strict=True))
    data = bytearray(piece[DELIVERY.size :])
    data[20] ^= fields.pop("byte", 0)
    return DELIVERY.pack(*(known | fields).values()) + data


NO_STATES: dict[str, tuple[Callable[[list[bytes]], list[bytes]], int]] = {
    "nothing": (lambda all_: all_, 5),
    "a byte is missing": (lambda all_: [*all_[:4], all_[4][:-1]], 4),
    "a head without data": (lambda all_: [*all_[:2], all_[2][: DELIVERY.size]], 2),
    "less than a head": (lambda all_: [*all_[:3], all_[3][: DELIVERY.size - 1]], 3),
    "a second state of a finger": (lambda all_: [*all_[:2], all_[1], *all_[2:]], 2),
    "a frame of somebody else": (lambda all_: [*all_[:2], changed(all_[2], identifier=0x7FF), *all_[3:]], 2),
    "an extended identifier": (lambda all_: [*all_[:2], changed(all_[2], flags=0xFF), *all_[3:]], 2),
    "a classic frame": (lambda all_: [*all_[:2], changed(all_[2], flags=0), *all_[3:]], 2),
    "no faster data": (
        lambda all_: [*all_[:2], changed(all_[2], flags=PLAIN_FLAGS & ~RATE_SWITCH), *all_[3:]], 5,
    ),
    "no such length": (lambda all_: [*all_[:2], changed(all_[2], code=16), *all_[3:]], 2),
    "broken data": (lambda all_: [*all_[:2], changed(all_[2], byte=1), *all_[3:]], 2),
    "broken at once": (lambda all_: [changed(all_[0], byte=1), *all_[1:]], 0),
    "empty": (lambda _: [], 0),
}  # fmt: skip


@pytest.mark.parametrize(
    ("what", "mode"), [*((what, "c") for what in NO_STATES), ("nothing", "python"), ("broken data", "python")]
)
def test_a_packet_is_taken_up_to_what_is_no_state_of_another_finger(what: str, mode: str) -> None:
    """Three are lost before it and one after the second; the numbers begin anew within it."""
    log, now = pressing_hand(1), 2_000_000_000
    node, codec = make_node(demo_parameters(), log.fingers), log.codec()
    node.configure()
    node.activate()
    node.run_compiled({name: line for name in FINGERS if (line := codec.line(name)) is not None}, mode)
    numbers = [0xFFFFFFFE, 0xFFFFFFFF, 1, 2, 3]
    whole = [
        delivery_of(number, Transmission(0, 100 + i, 1, BusFrame(event.frame.arbitration_id,
                    event.frame.data, fd=True, has_bit_rate_switch=True)), 200 + i)
        for i, (number, event) in enumerate(zip(numbers, log.events, strict=True)) if event.frame is not None
    ]  # fmt: skip
    change, count = NO_STATES[what]
    answer = node.on_packet(b"".join(change(whole)), 0xFFFFFFFB, now)
    assert [name for name in FINGERS if node.fingers[name].started] == list(FINGERS[:count])
    if not count:
        assert answer is None
        return
    assert answer is not None
    lost, expected = 3 + (count > 2), (numbers[count - 1] + 1) % 2**32
    size = sum(map(len, whole[:count]))
    assert answer.taken == (size, lost, expected, 99 + count, 199 + count)
    assert [(name, end) for name, _, end in answer.states] == [(FINGERS[i], 100 + i) for i in range(count)]
    assert all(done & COMMANDED for _, done, _ in answer.states)
    assert answer.commands == count
    requests = list(split_requests(bytes(answer.requests)))
    assert [time for time, _ in requests] == [now] * count
    assert [frame.identifier for _, frame in requests] == [
        node.fingers[name].numbers.on_wire.command_id for name in FINGERS[:count]
    ]
