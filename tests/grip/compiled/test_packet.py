"""A packet of frames is answered as its frames one by one: the same frames leave, and the same is counted."""

import socket
from collections.abc import Iterator
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
from vegrip.messages import FingertipState
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.canbus.frame_time import BusFrame
from vegrip.transport.canbus.hub_wire import MAX_GATHERED_BYTES
from vegrip.transport.canbus.virtual_can import VegripBus
from vegrip.trials.candidates import demo_parameters, make_node

pytestmark = pytest.mark.skipif(host.compiler() is None, reason="packets are answered by C")
FINGERS = ("thumb", "index", "middle", "ring", "little")
ROUNDS = 120
Frames = list[tuple[int, bytes]]


def pressing_hand() -> Log:
    """Return the frames of five fingers that press, 200 Hz, one after the other in every cycle."""
    log, rng = Log(FINGERS), np.random.default_rng(8)
    codec = log.codec()
    for seq in range(ROUNDS):
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
