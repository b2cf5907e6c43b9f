"""The kernels of the bus bring what the model brings: every frame, time, number and order, whatever happens.

Two hubs get the same packets at the same times. One carries all frames by the model; the other by the
kernels, in Python and in C, wherever there are no errors, and by the model in between.
"""

from collections import deque
from random import Random
from struct import pack
from types import SimpleNamespace

import pytest

from vegrip.host.compiled_folder import compiler
from vegrip.transport.canbus import compiled_bus, hub
from vegrip.transport.canbus.acceptance import pack_filters
from vegrip.transport.canbus.error_free_bus import ErrorFreeBus
from vegrip.transport.canbus.frame_time import FD_SIZES, BusFrame
from vegrip.transport.canbus.greeting import make_greeting
from vegrip.transport.canbus.hub_wire import MAX_GATHERED_BYTES, pack_request
from vegrip.transport.canbus.kernels import carry, deliveries, memory, requests
from vegrip.transport.canbus.kernels.limits import NO_EVENT, SLICE, TRANSMIT_QUEUE

START = 10**15  # [ns]
RATES = [
    (1_000_000, 5_000_000),
    (500_000, 500_000),
    (125_000, 2_000_000),
    (20_000_000, 20_000_000),
    (1000, 1000),
]
STEPS = 120


class Kernels:
    """The kernels in Python, called as those in C are."""

    def __init__(self, memory):
        both = memory.wholes, memory.bytes
        self.take_packet = lambda *given: requests.take_packet(*both, *given)
        self.advance = lambda *given: carry.advance(*both, *given)
        self.conclude = lambda now: carry.conclude(*both, now)
        self.hand_out = lambda now: deliveries.hand_out(*both, now)
        self.next_event = lambda: carry.next_event(memory.wholes)


class KernelsInC:
    def __init__(self, memory):
        functions, both = compiled_bus.CompiledBus(compiled_bus.compile_library()), memory.addresses
        self.take_packet = lambda *given: functions.take_packet(*both, *given)
        self.advance = lambda *given: functions.advance(*both, *given)
        self.conclude = lambda now: functions.conclude(*both, now)
        self.hand_out = lambda now: functions.hand_out(*both, now)
        self.next_event = lambda: functions.next_event(both[0])


class Connection:
    """Takes packets, unless it is full."""

    def __init__(self, number):
        self.number, self.taken, self.is_full, self.unread = number, [], False, deque()

    def fileno(self):
        return self.number

    def send(self, packet, _):
        if self.is_full:
            raise BlockingIOError
        self.taken.append(bytes(packet))

    def close(self):
        pass


class Bus:
    """A hub that is led step by step; without ``kernels`` the model carries all frames."""

    def __init__(self, clock, kernels=None):
        self.clock, self.hub = clock, hub.Hub(Connection(0))
        self.connections = []
        self.memory = ErrorFreeBus()
        self.kernels = kernels and kernels(self.memory)
        self.is_loaded = False
        self.carried = 0  # steps by the kernels

    def join(self, greeting):
        self.leave_kernels()
        self.hub._last_node += 1
        connection = Connection(len(self.connections) + 1)
        self.connections.append(connection)
        member = self.hub._members[connection.number] = hub.Member(self.hub._last_node, connection)
        self.hub._greet(member, greeting)

    def leave(self, number):
        self.leave_kernels()
        self.hub._take(self.hub._members[number], b"")

    def leave_kernels(self):
        if self.is_loaded:
            self.send()
            self.hub._due = self.memory.store(self.hub._bus)
            self.is_loaded = False

    def step(self):
        """Do what a step of the hub does after its sleep."""
        for member in self.hub._members.values():
            member.flush()
        if self.kernels and not self.is_loaded and not self.is_behind:
            self.is_loaded = self.memory.load(self.hub._bus, list(self.hub._nodes.values()), 0)
        if self.is_loaded:
            self.step_by_kernels()
        else:
            self.step_by_model()
        if self.is_behind:
            self.leave_kernels()

    @property
    def is_behind(self):
        return any(member.is_behind for member in self.hub._members.values())

    def step_by_model(self):
        bus = self.hub._bus
        self.hub._tell(bus, bus.conclude(self.clock.now))
        self.hub._hand_out()
        self.read_by_model()
        self.hub._advance()
        self.hub._hand_out()

    def read_by_model(self):
        for member in list(self.hub._members.values()):
            unread = member.connection.unread
            while unread and self.hub._has_room(member):
                self.hub._take(member, unread.popleft())

    def step_by_kernels(self):
        now = self.clock.now
        self.carried += 1
        self.kernels.conclude(now)
        self.kernels.hand_out(now)
        self.send()
        if not self.read_by_kernels():
            self.read_by_model()
            self.hub._advance()
            self.hub._hand_out()
            return
        event = self.kernels.next_event()
        while self.kernels.advance(min(now, event + SLICE), now):
            self.send()
        self.send()
        self.kernels.hand_out(now)
        self.send()

    def read_by_kernels(self):
        for slot, member in enumerate(self.hub._nodes.values()):
            unread = member.connection.unread
            while unread and self.waiting(slot) < TRANSMIT_QUEUE:
                packet = unread.popleft()
                self.memory.bytes[memory.RECEIVED : memory.RECEIVED + len(packet)] = packet
                if not self.kernels.take_packet(slot, len(packet), self.clock.now):
                    self.leave_kernels()
                    self.hub._take(member, packet)
                    return False
        return True

    def waiting(self, slot):
        return self.memory.wholes[memory.SLOTS + slot * memory.SLOT + memory.WAITING]

    def send(self):
        for node, packet in self.memory.unsent():
            self.hub._nodes[node].deliver(packet)

    def next_event(self):
        if not self.is_loaded:
            return self.hub._bus.next_event()
        event = self.kernels.next_event()
        return None if event == NO_EVENT else event


@pytest.fixture(params=["python", "c"])
def kernels(request):
    if request.param == "c" and compiler() is None:
        pytest.skip("no C compiler")
    return Kernels if request.param == "python" else KernelsInC


@pytest.fixture
def clock(monkeypatch):
    """A clock for both hubs that stands still within a step."""
    made = SimpleNamespace(now=START)
    made.monotonic_ns = lambda: made.now
    made.monotonic = lambda: made.now / 1e9
    monkeypatch.setattr(hub, "time", made)
    return made


IDENTIFIERS = [0, 0x100, 0x101, 0x123, 0x200, 0x7FF]


def some_frame(random):
    extended, kind = (
        random.random() < 0.2,
        random.choice(["fd", "fd", "classic", "remote", "slow fd", "fd remote"]),
    )
    identifier = random.choice(IDENTIFIERS) if random.random() < 0.8 else random.getrandbits(11)
    if extended:
        identifier = identifier << 18 | random.choice([0, 1, 0x3FFFF, random.getrandbits(18)])
    fd = "fd" in kind
    code = random.randrange(16 if fd else 9)
    data = random.choice([random.randbytes, bytes, lambda n: b"\xff" * n])(FD_SIZES[code])
    if "remote" in kind:
        data = b""
    switch, passive = fd and kind != "slow fd", fd and random.random() < 0.1
    return BusFrame(identifier, data, extended, "remote" in kind, fd, switch, passive, code)


def some_time(random, now):
    return max(now - random.choice([0, 0, 1, 1000, 250_000, 3_000_000, 5 * 10**9, -(10**9)]), 0)


def some_packet(random, now):
    """Return a request, several at once, filters, or what is none of these."""
    kind = random.random()
    if kind < 0.03:
        pairs = [
            (random.choice(IDENTIFIERS), random.choice([0, 0x7F0, 0x800007FF]))
            for _ in range(random.randrange(9))
        ]
        return pack_filters(pairs)
    if kind < 0.06:
        return random.choice([
            b"x",
            random.randbytes(random.randrange(1, 200)),
            pack("<QIBB", 1 << 63, 0x123, 4, 0),
            pack("<QIBB", now, 0x123, 4 + 32, 0),
            pack("<QIBB", now, 0x800, 0, 0),
            pack("<QIBB", now, 5, 0, 9) + bytes(12),
            pack("<QIBB", now, 5, 2, 0) * 3,
            pack("<QIBB", now, 5, 4, 16),
            pack("<QIBB", now, 5, 0, 0) * 290,
            pack_request(now, some_frame(random)) + b"1",
        ])  # fmt: skip
    several = random.choice([1, 1, 1, 2, 5, 16])
    time = some_time(random, now)
    frames = [some_frame(random) for _ in range(several)]
    if random.random() < 0.9 and several > 1:
        frames = [
            one for one in frames if not one.is_remote
        ]  # with one among them the packet is for the model
    return b"".join(pack_request(time, one) for one in frames) or pack_request(time, BusFrame(7))


FAULTS = [
    {"corruption": 0.3},
    {"misreading": 0.4},
    {"loss": 0.5},
    {"babble": 0x300},
    {"delay": 0.001},
    {"flips": 1.0},
]


def some_greeting(random, rates, *, faults):
    said = {
        "timing": {"bitrate": rates[0], "data_bitrate": rates[1]},
        "wants_own_frames": random.random() < 0.3,
        "listen_only": random.random() < 0.05,
        "patience": random.choice([None, None, 0.0, 0.0003, 0.05]),
        "faults": {**random.choice(FAULTS), "seed": random.getrandbits(9)} if faults else None,
    }
    return make_greeting(said)


def happen(random, rates, both, faulty):
    """Let something happen that both buses are told of."""
    now, there = both[0].clock.now, list(both[0].hub._members)
    kind = random.random()
    if kind < 0.04 or len(there) < 1:
        greeting = some_greeting(random, rates, faults=random.random() < faulty)
        for bus in both:
            bus.join(greeting)
    elif kind < 0.06:
        number = random.choice(there)
        for bus in both:
            bus.leave(number)
    elif kind < 0.09:
        full = random.choice(there) if random.random() < 0.15 else 0
        for bus in both:
            for connection in bus.connections:
                connection.is_full = connection.number == full
    elif kind < 0.12:
        both[1].leave_kernels()
    else:
        burst = 1 if random.random() < 0.98 else 90
        for _ in range(burst):
            number, packet = random.choice(there), some_packet(random, now)
            for bus in both:
                bus.connections[number - 1].unread.append(packet)


def test_the_memory_has_room_for_what_is_sent():
    assert memory.LONGEST_PACKET == hub.LONGEST_PACKET
    assert memory.GATHERED_BYTES == MAX_GATHERED_BYTES


@pytest.mark.parametrize("seed", range(25))
def test_the_kernels_carry_what_the_model_carries(seed, kernels, clock):
    random = Random(seed)  # noqa: S311 (no secret)
    rates = random.choice(RATES) if seed % 2 else RATES[0]
    both = [Bus(clock), Bus(clock, kernels)]
    frame = 200_000_000_000 // rates[0]  # [ns] about
    faulty = 0.0 if seed % 3 else 0.3  # share of newcomers with faults
    for _ in range(4):
        greeting = some_greeting(random, rates, faults=False)
        for bus in both:
            bus.join(greeting)
    for _ in range(STEPS):
        for _ in range(random.choice([0, 1, 1, 2, 5])):
            happen(random, rates, both, faulty)
        for bus in both:
            bus.step()
        assert both[0].next_event() == both[1].next_event()
        assert [c.taken for c in both[0].connections] == [c.taken for c in both[1].connections]
        clock.now += random.choice(
            [0, random.randrange(frame), random.randrange(5 * frame), 1000 * frame // 4]
        )
    both[1].leave_kernels()
    assert both[0].hub._bus.busy == both[1].hub._bus.busy
    assert both[0].hub._bus.error_free_state() == both[1].hub._bus.error_free_state()
    assert both[1].carried > (STEPS // 20 if faulty == 0.0 else 0)
