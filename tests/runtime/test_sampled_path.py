"""A hand whose samples and commands go past the messages does what one does that sends and hears messages."""

import random
import socket
from collections import Counter
from dataclasses import asdict, replace

import pytest
from vegrip.nodes.virtual_hand import Parameters, VirtualHandNode

from validation.bus_bytes import delivery_of, split_requests
from vegrip.clock import NS, SimulatedClock
from vegrip.messages import FingertipState, ForceCommand, NodeStatus, Reason
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.runtime.telemetry import Direction, Telemetry
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.canbus import virtual_can
from vegrip.transport.canbus.bus_events import Transmission
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.row_kernels import pack_states, read_commands
from vegrip.virtual import HandSettings
from vegrip.virtual.settings import SensorSettings

HAND = HandSettings()
LOSSY = replace(HAND, sensor=SensorSettings(dropout=0.1, jitter=1e-4, torque_z=1e38))
START = 10**12
LIFE = NS // 10


class CountingSink:
    """Counts every message; shows all of them, or none."""

    def __init__(self, *, shows: bool) -> None:
        self.wanted, self.counted = shows, Counter()

    def takes(self, *_):
        return False

    def wants(self, *_):
        return self.wanted

    def count(self, message, direction):
        if not isinstance(message, NodeStatus):
            self.counted[type(message), message.finger, direction] += 1

    def tally(self, kind, owner, direction):
        self.counted[kind, owner, direction] += 1

    def listen(self):
        pass

    def publish(self, messages):
        pass

    def close(self):
        pass


class Rig:
    """A hand on a bus whose hub is this test."""

    def __init__(self, monkeypatch, settings: HandSettings, *, shows: bool, sender_time: bool) -> None:
        ours, self.hub = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for one in (ours, self.hub):
            one.setblocking(False)
        answer = {"node": 1, "timing": asdict(BitTiming()), "busy": 0}
        monkeypatch.setattr(virtual_can, "_join", lambda *_: (ours, answer))
        self.bus = virtual_can.VegripBus("test", fd=True)
        codec = CanCodec(settings.fingers, fd=True, use_sender_time=sender_time)
        self.endpoint = CanEndpoint(self.bus, codec)
        self.clock, self.sink = SimulatedClock(START), CountingSink(shows=shows)
        self.node = VirtualHandNode("virtual_hand", replace(Parameters(), hand=settings, disturbed=False))
        loop, telemetry = LoopSettings(tick_period=0.002, status_period=0.1), Telemetry(self.sink)
        self.runner = Runner(self.node, self.endpoint, self.clock, loop, telemetry)
        self.runner.start()
        self.sent: list[tuple[int, bytes]] = []
        self.read()  # what comes before the first sample: filters

    def read(self) -> None:
        while True:
            try:
                packet = self.hub.recv(4096)
            except BlockingIOError:
                return
            self.sent += [(frame.identifier, frame.data) for _, frame in split_requests(packet)]

    def turn(self, packets: list[bytes]) -> None:
        """Have the hand look at ``packets`` and sample."""
        for packet in packets:
            self.hub.send(packet)
        due = self.runner.schedule.due
        while self.runner.schedule.due == due:
            self.runner.step()
        while self.runner._more:  # the way of messages looks again when something has come
            self.runner.step()
        self.read()

    def close(self) -> None:
        self.bus.shutdown()
        self.hub.close()

    @property
    def outcome(self):
        statistics = self.runner.statistics
        counts = statistics.states_sent, statistics.commands_received, dict(self.sink.counted)
        refused = dict(self.endpoint.rejected), self.node.refused
        return self.sent, self.node.commands, refused, counts, self.bus.overruns, self.bus._load._busy


class Traffic:
    """Commands as they may come, good and bad; the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self.random, self.codec = random.Random(seed), CanCodec(HAND.fingers, fd=True)  # noqa: S311
        self.seq, self.number, self.busy = Counter(), 2**32 - 40, 0

    def packets(self, now: int) -> list[bytes]:
        packets = []
        for finger in HAND.fingers:
            for frame in self.frames(finger, now):
                self.number += 1 if self.random.random() < 0.99 else 3
                self.busy += 1000
                sent = Transmission(now + self.random.randrange(1000), now, 2, frame)
                packets.append(delivery_of(self.number, sent, self.busy))
        return packets

    def frames(self, finger: str, now: int) -> list[BusFrame]:
        choose = self.random.random
        self.seq[finger] += 1 if choose() < 0.97 else self.random.choice([0, 2, -1, 2**31])
        force = 2.0 if choose() < 0.97 else self.random.choice([-1.0, 3e38, 0.0])
        life = LIFE if choose() < 0.97 else self.random.choice([0, 10**6, 2 * 10**9])
        stamp = now if choose() < 0.97 else now + self.random.choice([-NS, 2 * NS])
        command = ForceCommand(stamp, finger, self.seq[finger], force, 0.1, Reason.RAISE, stamp + life)
        made: list[Frame] = self.codec.encode(command)
        if choose() < 0.01:
            made += self.codec.encode(FingertipState(now, finger, self.seq[finger], 1.0))
        if choose() < 0.01:
            made.append(Frame(self.random.choice([0x7FF, 0x123]), bytes(24), True))
        return [BusFrame(one.arbitration_id, self.changed(one.data), fd=True) for one in made]

    def changed(self, data: bytes) -> bytes:
        if self.random.random() > 0.02:
            return data
        broken = bytearray(data)
        broken[self.random.randrange(len(data))] ^= 1 << self.random.randrange(8)
        return bytes(broken) if self.random.random() < 0.7 else data[:16]


@pytest.mark.parametrize("settings", [HAND, LOSSY], ids=["as it is", "lossy"])
@pytest.mark.parametrize("sender_time", [False, True])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_bus_the_hand_and_all_counts_are_those_of_messages(monkeypatch, settings, sender_time, seed):
    rigs = [Rig(monkeypatch, settings, shows=shows, sender_time=sender_time) for shows in (False, True)]
    for rig in rigs:
        traffic = Traffic(seed)
        for _ in range(400):
            rig.turn(traffic.packets(rig.clock.now()))
        rig.close()
    short, long = (rig.outcome for rig in rigs)
    assert short == long
    assert len(short[0]) > 0.85 * 400 * 5
    assert short[2][0]["checksum"] > 0


def test_a_hand_that_is_watched_for_a_while_goes_on_without_a_gap(monkeypatch):
    rigs = [Rig(monkeypatch, HAND, shows=shows, sender_time=True) for shows in (False, True)]
    for rig in rigs:
        traffic = Traffic(5)
        for turn in range(300):
            rig.sink.wanted = rig.sink.wanted if turn % 100 < 50 else not rig.sink.wanted
            rig.turn(traffic.packets(rig.clock.now()))
        rig.close()
    assert rigs[0].outcome == rigs[1].outcome


def test_a_hand_that_fails_is_put_on_hold(monkeypatch):
    rig = Rig(monkeypatch, HAND, shows=False, sender_time=True)
    traffic = Traffic(0)
    rig.turn(traffic.packets(rig.clock.now()))
    monkeypatch.setattr(rig.node.hand, "advance", lambda *_: 1 / 0)
    rig.turn(traffic.packets(rig.clock.now()))
    assert rig.runner.managed.on_hold
    assert rig.runner.managed.faults == {"fault ZeroDivisionError": 1}
    rig.close()


def test_a_bus_that_has_gone_is_counted_and_does_not_end_the_loop(monkeypatch):
    rig = Rig(monkeypatch, HAND, shows=False, sender_time=True)
    rig.turn([])
    rig.hub.close()
    for _ in range(5):
        rig.runner.step()
    assert rig.endpoint.rejected["unsent"] > 0
    assert rig.endpoint.rejected["bus_lost"] > 0
    rig.bus.shutdown()


def test_states_are_counted_for_the_telemetry(monkeypatch):
    rig = Rig(monkeypatch, HAND, shows=False, sender_time=True)
    for _ in range(10):
        rig.turn([])
    for finger in HAND.fingers:
        assert rig.sink.counted[FingertipState, finger, Direction.OUT] == 9  # none at time zero
    rig.close()


def test_nothing_is_compiled_in_the_loop(monkeypatch):
    rig = Rig(monkeypatch, HAND, shows=False, sender_time=True)
    compiled = [len(kernel.signatures) for kernel in (pack_states, read_commands)]
    traffic = Traffic(0)
    for _ in range(5):
        rig.turn(traffic.packets(rig.clock.now()))
    assert compiled == [len(kernel.signatures) for kernel in (pack_states, read_commands)]
    assert min(compiled) >= 1
    rig.close()
