"""Golden answers of the bus: what happens in seeded scripts, and what members are brought, as digests.

A script is a bus of random rates, nodes and faults, and what they do: requests in bursts, nodes that come,
leave, or get other faults, looks at random times. In the others members send packets of any content, and the
bytes that they are brought count. ``python tests/transport/canbus/bus_scripts.py`` writes the digests anew;
nothing of them changes unless the bus does.
"""

import hashlib
import itertools
import json
import socket
from collections import deque
from contextlib import suppress
from pathlib import Path
from random import Random
from struct import pack

from validation.bus_bytes import request_of
from validation.faults.simulated_bus import BusError, SimulatedBus, StateChange, Transmission
from vegrip.transport.canbus import carry
from vegrip.transport.canbus.bus_events import NodeFaults
from vegrip.transport.canbus.bus_records import SLICE, TRANSMIT_QUEUE
from vegrip.transport.canbus.frame_time import FD_SIZES, BitTiming, BusFrame
from vegrip.transport.canbus.hub_wire import (
    make_greeting,
    pack_filters,
    read_greeting,
    split_deliveries,
    unpack_filters,
)

GOLDEN = Path(__file__).parent / "golden_bus.json"
GROUPS, IN_A_GROUP = 60, 20


def digests(functions=carry, groups=range(GROUPS)):
    """Return the digest of each group of scripts; ``functions`` as of :class:`SimulatedBus`."""
    return {
        f"{kind} {group}": digest(
            "\n".join(line for script in scripts_of(group) for line in make(script, functions).run())
        )
        for kind, make, most in (("events", Script, GROUPS), ("deliveries", MemberScript, 20))
        for group in groups
        if group < most
    }


def is_healthy(model):
    """Return whether no node has errors, and none is made to have some."""
    return model.record.troubled + model.record.off + model.record.faulty == 0


def scripts_of(group):
    return range(group * IN_A_GROUP, (group + 1) * IN_A_GROUP)


def digest(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def golden():
    """Return the digests that are kept."""
    return json.loads(GOLDEN.read_text())


class Script:
    def __init__(self, seed, functions=carry):
        self.chance = Random(seed)  # noqa: S311 (no secret)
        bitrate = self.chance.choice([1_000_000, 500_000, 125_000, 10_000])
        self.timing = BitTiming(bitrate, self.chance.choice([5_000_000, 2_000_000, bitrate]))
        self.unit = 10**9 // bitrate * 120  # [ns] about a frame
        self.model = SimulatedBus(self.timing, functions)
        self.kind = seed % 6  # no errors, lossy, corrupted, misread, all of it, a lone node
        self.time = self.chance.choice([0, 10**15])
        self.nodes, self.number, self.lines = [], 0, []

    def run(self):
        for _ in range(1 if self.kind == 5 else self.chance.randint(2, 7)):
            self.join()
        for _ in range(self.chance.randint(20, 60)):
            self.time += round(self.chance.expovariate(1 / self.unit))
            self.act()
        for _ in range(8):
            self.time += self.unit * self.chance.choice([1, 30, 500])
            self.look()
        return self.lines

    def act(self):
        what = self.chance.random()
        if what < 0.02 or not self.nodes:
            self.join()
        elif what < 0.04:
            self.model.detach(self.nodes.pop(self.chance.randrange(len(self.nodes))))
        elif what < 0.06 and self.kind:
            self.model.endure(self.chance.choice(self.nodes), self.faults(), self.time)
        elif what < 0.35:
            self.look()
        elif what < 0.40:
            self.note(self.model.conclude(self.time))
        else:
            node = self.chance.choice(self.nodes)
            for _ in range(self.chance.choice([1, 1, 1, 2, 8])):
                taken = self.model.request(self.time - self.chance.randrange(self.unit), node, self.frame())
                self.lines.append(f"request {node} {taken:d} {self.model.waiting(node)}")

    def join(self):
        self.model.advance(self.time)
        self.number += self.chance.randint(1, 3)
        listens = self.chance.random() < 0.15
        self.model.attach(self.number, listen_only=listens, faults=self.faults(), time=self.time)
        self.nodes.append(self.number)

    def look(self):
        event = self.model.next_event()
        if event is not None and self.chance.random() < 0.3:
            self.time = max(self.time, event)
        self.note(self.model.advance(self.time))
        heard = [self.model.is_received(node) for node in self.nodes]
        states = [(node, int(self.model.state(node)), *self.model.counters(node)) for node in self.nodes]
        self.lines.append(
            f"look {self.time} {event} {self.model.next_event()} {self.model.busy} {self.model.queued} "
            f"{is_healthy(self.model):d} {states} {heard}"
        )

    def note(self, events):
        for event in events:
            match event:
                case Transmission(start, end, node, frame, is_lost, missed_by):
                    line = f"sent {start} {end} {node} {frame_text(frame)} {is_lost:d} {missed_by}"
                case BusError(start, end, node, frame, kind, found_by, counters):
                    told = sorted(counters.items())
                    line = f"error {start} {end} {node} {frame_text(frame)} {kind.name} {found_by} {told}"
                case StateChange(time, node, state, counters, dropped):
                    line = f"state {time} {node} {int(state)} {counters} {dropped}"
            self.lines.append(line)

    def faults(self):
        share = self.chance.choice([0.0, 0.02, 0.3, 1.0])
        seed = self.chance.randrange(1 << self.chance.choice([4, 32, 70]))
        if self.kind == 0 or self.chance.random() < 0.4:
            return NodeFaults()
        if self.kind == 1:
            return NodeFaults(loss=share, flips=self.chance.random(), seed=seed)
        if self.kind == 2:
            return NodeFaults(corruption=share, seed=seed)
        if self.kind == 3:
            return NodeFaults(misreading=share, seed=seed)
        return NodeFaults(
            loss=self.chance.choice([0.0, 0.3]),
            corruption=self.chance.choice([0.0, share]),
            misreading=self.chance.choice([0.0, share]),
            flips=self.chance.choice([0.0, 0.3]),
            delay=self.chance.choice([0.0, 0.002, 2.5]),
            jitter=self.chance.choice([0.0, 0.003, 3.0]),
            babble=self.chance.choice([-1, -1, -1, 0x7FF, 0x0]),
            seed=seed,
        )

    def frame(self):
        return some_frame(self.chance)


def some_frame(chance):
    extended, fd, remote = chance.random() < 0.3, chance.random() < 0.5, chance.random() < 0.1
    identifier = chance.choice([0, 1, chance.getrandbits(11), chance.getrandbits(29 if extended else 11)])
    if remote and not fd:
        return BusFrame(identifier, b"", extended, is_remote=True, length_code=chance.randint(0, 8))
    size = chance.choice(FD_SIZES if fd else FD_SIZES[:9])
    data = chance.choice([bytes(size), b"\xff" * size, chance.randbytes(size), chance.randbytes(size)])
    switch, passive = fd and chance.random() < 0.6, fd and chance.random() < 0.1
    return BusFrame(identifier, data, extended, False, fd, switch, passive)


def frame_text(frame):
    kind = "".join(letter for letter, has in zip("xrfsp", frame[2:7], strict=True) if has)
    return f"{frame.identifier:x}:{kind}:{frame.code}:{frame.data.hex()}"


class MemberScript:
    """Members of a hub, led step by step; what they are brought."""

    def __init__(self, seed, functions=carry, bus=None):
        self.chance = Random(seed)  # noqa: S311 (no secret)
        self.rates = self.chance.choice([(1_000_000, 5_000_000), (500_000, 500_000), (125_000, 2_000_000)])
        self.unit = 10**9 // self.rates[0] * 200  # [ns] about a frame
        self.share_of_faulty = 0.0 if seed % 3 else 0.3
        self.bus = bus or LedBus(self.rates, functions)
        self.now = 10**15
        self.lines = []

    def run(self):
        for _ in range(3):
            self.join()
        for _ in range(40):
            for _ in range(self.chance.choice([0, 1, 1, 2, 5])):
                self.act()
            for member, packets in self.bus.step(self.now).items():
                deliveries = [one for packet in packets for one in split_deliveries(packet)]
                if packets:
                    self.lines.append(f"{self.now} {member} {[len(packet) for packet in packets]}")
                self.lines += [f"{member} {comparable(delivery)}" for delivery in deliveries]
            steps = [
                0,
                self.chance.randrange(self.unit),
                self.chance.randrange(5 * self.unit),
                250 * self.unit,
            ]
            self.now += self.chance.choice(steps)
        self.bus.close()
        return self.lines

    def act(self):
        what = self.chance.random()
        if what < 0.04 or not self.bus.members:
            self.join()
        elif what < 0.06:
            self.bus.leave(self.chance.choice(list(self.bus.members)))
        else:
            for _ in range(1 if self.chance.random() < 0.98 else 90):
                self.bus.give(self.chance.choice(list(self.bus.members)), self.packet())

    def join(self):
        faults = {"seed": self.chance.getrandbits(9)} if self.chance.random() < self.share_of_faulty else {}
        if faults:
            kinds = [
                {"corruption": 0.3},
                {"misreading": 0.4},
                {"loss": 0.5},
                {"delay": 0.001},
                {"flips": 1.0},
            ]
            faults |= self.chance.choice(kinds)
        greeting = {
            "timing": {"bitrate": self.rates[0], "data_bitrate": self.rates[1]},
            "wants_own_frames": self.chance.random() < 0.3,
            "listen_only": self.chance.random() < 0.05,
            "patience": self.chance.choice([None, None, 0.0, 0.0003, 0.05]),
            "faults": faults,
        }
        self.bus.join(self.now, make_greeting(greeting))

    def packet(self):
        """Return a request, several at once, filters, or what is none of these."""
        chance, kind = self.chance, self.chance.random()
        if kind < 0.03:
            masks = [0, 0x7F0, 0x800007FF]
            return pack_filters(
                [(chance.getrandbits(11), chance.choice(masks)) for _ in range(chance.randrange(9))]
            )
        if kind < 0.06:
            return chance.choice(
                [
                    b"x",
                    chance.randbytes(chance.randrange(1, 200)),
                    pack("<QIBB", 1 << 63, 0x123, 4, 0),
                    pack("<QIBB", self.now, 0x800, 0, 0),
                    pack("<QIBB", self.now, 5, 0, 9) + bytes(12),
                    pack("<QIBB", self.now, 5, 2, 0) * 3,
                    pack("<QIBB", self.now, 5, 4, 16),
                    pack("<QIBB", self.now, 5, 0, 0) * 290,
                ]
            )
        time = max(self.now - chance.choice([0, 0, 1, 1000, 250_000, 3_000_000, 5 * 10**9, -(10**9)]), 0)
        frames = [some_frame(chance) for _ in range(chance.choice([1, 1, 1, 2, 5, 16]))]
        if len(frames) > 1:
            frames = [frame for frame in frames if not frame.is_remote] or [BusFrame(7)]
        return b"".join(request_of(time, frame) for frame in frames)


def comparable(delivery):
    """Return a delivery as text, without for how long the bus was busy by then.

    The first bus told it too early where a lone node went on to repeat its frame in the same step.
    """
    return (delivery[:12] + delivery[20:]).hex()


class LedBus:
    """What the hub does, step by step at times that are given."""

    def __init__(self, rates, functions):
        self.text = functions
        self.model = SimulatedBus(BitTiming(*rates), functions)
        self.record, self.memory = self.model.record, self.model._bus
        self.members, self.brought, self.numbers = {}, {}, itertools.count(1)

    def join(self, now, packet):
        self.catch_up(now)
        greeting, number = read_greeting(packet), next(self.numbers)
        self.model.attach(number, listen_only=greeting.listen_only, faults=greeting.faults, time=now)
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        node = self.model.node(number)
        node.descriptor, node.hears_itself = ours.fileno(), greeting.wants_own_frames
        if greeting.patience >= 0.0:
            node.patience = round(greeting.patience * 1e9)
        self.members[number], self.brought[number] = (ours, theirs, deque()), []

    def leave(self, number):
        ours, theirs, _ = self.members.pop(number)
        self.model.detach(number)
        ours.close()
        theirs.close()

    def give(self, number, packet):
        self.members[number][2].append(packet)

    def step(self, now):
        if self.text.conclude(self.memory, now):
            self.bring(now)
        self.hand_out(now)
        for number, (_, _, unread) in self.members.items():
            while unread and self.model.waiting(number) < TRANSMIT_QUEUE:
                self.take(number, unread.popleft(), now)
        self.catch_up(now)
        self.hand_out(now)
        brought, self.brought = self.brought, {number: [] for number in self.members}
        return brought

    def take(self, number, packet, now):
        self.record.packet[: len(packet)] = packet
        slot = self.model._slots[number]
        taken = self.text.take_packet(self.memory, slot, len(packet), now)
        if not taken and (pairs := unpack_filters(packet)) is not None:
            self.model.accept(number, pairs)

    def catch_up(self, now):
        limit = min(now, (self.model.next_event() or now) + SLICE)
        while self.text.advance(self.memory, limit):
            self.bring(now)

    def bring(self, now):
        self.text.bring_events(self.memory, now)
        self.model._forget()
        self.drain()

    def hand_out(self, now):
        self.text.hand_out(self.memory, now)
        self.drain()

    def drain(self):
        assert self.record.unsent == 0
        for number, (_, theirs, _) in self.members.items():
            with suppress(BlockingIOError):
                while True:
                    self.brought[number].append(theirs.recv(4096, socket.MSG_DONTWAIT))

    def close(self):
        for number in list(self.members):
            self.leave(number)


if __name__ == "__main__":
    GOLDEN.write_text(json.dumps(digests(carry), indent=0) + "\n")
