"""The virtual CAN bus by seeded scripts: events of its model, and the packets that its members receive."""

import json
import socket
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

from validation.golden.store import Answered, digest
from validation.golden.world import Item, World, present
from vegrip.transport.canbus.acceptance import pack_filters
from vegrip.transport.canbus.bus_events import BusError, Event, StateChange
from vegrip.transport.canbus.bus_model import BusModel
from vegrip.transport.canbus.frame_time import FD_SIZES, BitTiming, BusFrame
from vegrip.transport.canbus.greeting import make_greeting
from vegrip.transport.canbus.hub import Hub
from vegrip.transport.canbus.hub_wire import pack_request
from vegrip.transport.canbus.node_faults import NO_FAULTS, NodeFaults

SCRIPTS, IN_ONE = 1000, 50  # of the model; so many under one name
HUBS, HUBS_IN_ONE = 120, 20
STEPS = 120
RATES = (
    (1_000_000, 5_000_000), (500_000, 500_000), (125_000, 2_000_000), (20_000_000, 20_000_000),
    (1_000, 1_000),
)  # fmt: skip
READ_NS = 400_000  # [ns] between two looks of the members at what they got
LONGEST_PACKET = 4096


def frame(dice: Random) -> BusFrame:
    """Return any frame that there can be."""
    extended, fd = dice.random() < 0.2, dice.random() < 0.6
    identifier = dice.randrange(1 << 29) if extended else dice.choice((0, 1, 0x100, 0x101, 0x555, 0x7FF))
    if not fd and dice.random() < 0.15:
        return BusFrame(identifier, b"", extended, is_remote=True, length_code=dice.randrange(9))
    size = dice.choice(FD_SIZES) if fd else dice.randrange(9)
    data = bytes(size) if dice.random() < 0.2 else dice.randbytes(size)
    return BusFrame(identifier, data, extended, False, fd, fd and dice.random() < 0.7)


def faults(dice: Random) -> NodeFaults:
    """Return faults of a node."""
    shares = {
        name: dice.choice((0.0, 0.0, 0.05, 0.5)) for name in ("loss", "corruption", "misreading", "flips")
    }
    late = {"delay": dice.choice((0.0, 0.0, 1e-4)), "jitter": dice.choice((0.0, 0.0, 1e-3))}
    babble = dice.choice((-1, -1, -1, -1, 0x050))
    return NodeFaults(**shares, **late, babble=babble, seed=dice.randrange(1000))


def events_of(seed: int) -> Iterator[str]:
    """Yield what happens on the bus of one script."""
    dice = Random(seed)  # noqa: S311 (no secret)
    timing = BitTiming(*dice.choice(RATES))
    bus, now, nodes, last = BusModel(timing), 0, list[int](), 0
    bit = 1e9 / timing.bitrate
    for _ in range(STEPS):
        chance = dice.random()
        if len(nodes) < 2 or (chance < 0.03 and len(nodes) < 7):
            last += 1
            nodes.append(last)
            is_bad = seed % 2 and dice.random() < 0.4
            bad = faults(dice) if is_bad else NO_FAULTS
            bus.attach(last, listen_only=dice.random() < 0.1, faults=bad, time=now)
        elif chance < 0.05:
            bus.detach(nodes.pop(dice.randrange(len(nodes))))
        elif chance < 0.08 and seed % 2:
            bus.endure(dice.choice(nodes), faults(dice) if dice.random() < 0.5 else NO_FAULTS, now)
        elif chance < 0.8:
            node = dice.choice(nodes)
            taken = bus.request(now, node, frame(dice))
            yield f"{node} {taken} {bus.waiting(node)}"
        else:
            now += int(bit * 10 ** dice.uniform(0.0, 3.7))
            for event in bus.conclude(now) if dice.random() < 0.2 else bus.advance(now):
                yield said(event)
            yield f"{now} {bus.busy} {bus.queued} {bus.next_event()} {bus.is_healthy}"
    for event in bus.advance(now + int(bit * 1e5)):
        yield said(event)


def said(event: Event) -> str:
    """Return an event as text."""
    if isinstance(event, StateChange):
        return f"{event.time} {event.node} {event.state.name} {event.counters} {event.dropped}"
    sent = " ".join(str(int(one)) if not isinstance(one, bytes) else one.hex() for one in event.frame)
    rest = (
        f"{event.is_lost} {event.missed_by}"
        if not isinstance(event, BusError)
        else f"{event.kind.name} {event.found_by}"
    )
    counters = sorted(event.counters.items()) if isinstance(event, BusError) else ""
    return f"{event.start} {event.end} {event.node} {sent} {rest} {counters}"


class _Members:
    """The members of one hub."""

    def __init__(self, seed: int, path: str) -> None:
        self._dice, self._path = Random(seed), path  # noqa: S311 (no secret)
        self._is_bad = bool(seed % 2)
        self._members: list[socket.socket] = []
        self.got: list[list[str]] = []
        self._readers: list[bool] = []
        self.world: World

    def items(self) -> list[Item]:
        """Return what they do, and when."""
        found, now = [Item(0, self._join), Item(0, self._join)], 0
        for _ in range(STEPS):
            now += int(10 ** self._dice.uniform(3.0, 6.5))
            chance = self._dice.random()
            does = (
                self._join if chance < 0.04
                else self._leave if chance < 0.06
                else self._filter if chance < 0.1
                else self._stop_reading if chance < 0.11
                else self._several if chance < 0.2
                else self._nonsense if chance < 0.21
                else self._send
            )  # fmt: skip
            found.append(Item(now, does))
        looks = [Item(at, self.read) for at in range(READ_NS, now + 50_000_000, READ_NS)]
        end = [Item(now + 50_000_000, self._end)]
        return sorted((*found, *looks, *end), key=lambda item: item.now)

    def _join(self) -> None:
        dice, near = self._dice, socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        near.connect(self._path)
        near.setblocking(False)
        bad = faults(dice) if self._is_bad and dice.random() < 0.3 else NO_FAULTS
        shares = {name: getattr(bad, name) for name in NodeFaults.__dataclass_fields__}
        table = {
            "wants_own_frames": dice.random() < 0.3,
            "listen_only": dice.random() < 0.1,
            "patience": dice.choice((None, None, 0.0, 1e-3)),
            "timing": {"bitrate": 1_000_000, "data_bitrate": dice.choice((5_000_000, 5_000_000, 2_000_000))},
            "must_match_rates": dice.random() < 0.2,
            "faults": shares,
        }
        near.send(make_greeting(table))
        self._members.append(near)
        self.got.append([])
        self._readers.append(True)

    def _any(self) -> socket.socket:
        return self._dice.choice(self._members)

    def _put(self, member: socket.socket, packet: bytes) -> None:
        try:
            member.send(packet)
        except OSError as error:
            self.got[self._members.index(member)].append(f"{self.world.time} {type(error).__name__}")

    def _send(self) -> None:
        self._put(self._any(), pack_request(self.world.time, frame(self._dice)))

    def _several(self) -> None:
        times = [self.world.time - self._dice.randrange(100_000) for _ in range(self._dice.randrange(2, 9))]
        self._put(self._any(), b"".join(pack_request(max(0, time), frame(self._dice)) for time in times))

    def _nonsense(self) -> None:
        self._put(self._any(), self._dice.randbytes(self._dice.randrange(1, 40)))

    def _filter(self) -> None:
        pairs = [(self._dice.choice((0x100, 0x101, 0x555)), 0x7FF) for _ in range(self._dice.randrange(3))]
        self._put(self._any(), pack_filters(pairs))

    def _stop_reading(self) -> None:
        self._readers[self._dice.randrange(len(self._members))] = False

    def _leave(self) -> None:
        if len(self._members) > 2:
            self._any().close()

    def read(self) -> None:
        """Take what has come."""
        for member, reads, got in zip(self._members, self._readers, self.got, strict=True):
            if reads and member.fileno() >= 0:
                self._drain(member, got)

    def _drain(self, member: socket.socket, got: list[str]) -> None:
        while True:
            try:
                packet = member.recv(LONGEST_PACKET)
            except BlockingIOError:
                return
            except OSError as error:
                got.append(f"{self.world.time} {type(error).__name__}")
                return
            got.append(f"{self.world.time} {_opened(packet)}")
            if not packet:
                member.close()
                return

    def _end(self) -> None:
        self._readers = [True] * len(self._members)
        self.read()
        for member in self._members:
            member.close()


def _opened(packet: bytes) -> str:
    try:
        return json.dumps(json.loads(packet), sort_keys=True)
    except ValueError:
        return packet.hex()


def received(seed: int) -> Iterator[str]:
    """Yield what the members of one hub receive, member by member."""
    with tempfile.TemporaryDirectory(prefix="vegrip-") as folder:
        path = str(Path(folder) / "bus")
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
            listener.bind(path)
            listener.listen(64)
            members = _Members(seed, path)
            with present(World(members.items(), lambda item: item.thing())) as world:
                members.world = world
                Hub(listener).serve()
    for number, got in enumerate(members.got):
        yield from (f"{number} {line}" for line in got)


@dataclass(frozen=True)
class OfBus:
    """Scripts under one name: of the model, or of hubs."""

    first: int
    of_hub: bool

    @property
    def name(self) -> str:
        """Return its name in the file."""
        count = HUBS_IN_ONE if self.of_hub else IN_ONE
        return f"{'hub' if self.of_hub else 'bus'}, scripts {self.first} to {self.first + count - 1}"

    def __call__(self) -> Answered:
        """Return what the scripts brought; the lines are digests of single scripts."""
        seeds = range(self.first, self.first + (HUBS_IN_ONE if self.of_hub else IN_ONE))
        lines, count = [], 0
        for seed in seeds:
            happened = list(received(seed) if self.of_hub else events_of(seed))
            count += len(happened)
            lines.append(f"script {seed}: {len(happened)} lines, {digest(happened)}")
        return Answered(self.name, {"events": lines}, {"events": count})


def scripts() -> list[OfBus]:
    """Return all of them."""
    model = [OfBus(first, False) for first in range(0, SCRIPTS, IN_ONE)]
    return [*model, *(OfBus(first, True) for first in range(0, HUBS, HUBS_IN_ONE))]
