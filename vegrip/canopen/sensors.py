"""The fingers of a hand as CANopen nodes: whether they are there, right, and go on beating."""

import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from canopen.objectdictionary import ObjectDictionary

from vegrip.canopen import network

ANSWER_TIMEOUT_NS = 500_000_000  # [ns] for an answer
RETRIES = 3
UPLOAD, ABORT = 0x40, 0x80  # command specifiers; an expedited answer has bit 1, its size in bits 2 and 3


class SdoReader:
    """Reads numbers of at most 32 bits (expedited transfer) from one device."""

    def __init__(self, asked: Sequence[tuple[int, int]], send: Callable[[bytes], None]) -> None:
        self.values: dict[tuple[int, int], int | None] = {}
        """What was read; None where the device refused."""
        self.failed = False
        self._asked = list(asked)
        self._send = send
        self._sent: int | None = None  # [ns]
        self._tries = 0

    @property
    def is_done(self) -> bool:
        return self.failed or len(self.values) == len(self._asked)

    def serve(self, now: int) -> None:
        """Ask the next question, or again after ``ANSWER_TIMEOUT_NS``."""
        if self.is_done or (self._sent is not None and now - self._sent < ANSWER_TIMEOUT_NS):
            return
        if self._tries >= RETRIES:
            self.failed = True
            return
        self._tries += 1
        self._sent = now
        self._send(struct.pack("<BHB4x", UPLOAD, *self._asked[len(self.values)]))

    def answer(self, data: bytes, now: int) -> None:
        """Take the 8 bytes of an answer; one that was not asked for is passed over."""
        if self.is_done or len(data) != 8:
            return
        command, index, sub = struct.unpack_from("<BHB", data)
        if (index, sub) != self._asked[len(self.values)]:
            return
        if command == ABORT:
            self._store(None, now)
        elif command & 0xE2 == UPLOAD | 0x02:
            size = 4 - (command >> 2 & 3) if command & 1 else 4
            self._store(int.from_bytes(data[4 : 4 + size], "little"), now)

    def _store(self, value: int | None, now: int) -> None:
        self.values[self._asked[len(self.values)]] = value
        self._sent, self._tries = None, 0
        self.serve(now)


@dataclass(slots=True)
class _Watched:
    limit: int  # [ns]
    received_at: int  # [ns] when last; when the watch began, if never
    state: int | None = None  # of the last heartbeat
    missing: bool = False
    grace: int = 0  # [ns] on top of the limit until the first heartbeat


class HeartbeatConsumer:
    """Watches that nodes go on beating.

    A node is missing when it was silent for longer than its limit, or nothing at all for ``first``
    since the watch began; stricter than CiA 301, which begins to watch with the first heartbeat and so never
    misses a node that was never there.
    """

    def __init__(self, limits: Mapping[int, int], now: int, first: int = 0) -> None:
        self._nodes = {  # limit and first in [ns], by node-ID
            node: _Watched(limit, now, grace=max(first - limit, 0)) for node, limit in limits.items()
        }

    def take_heartbeat(self, node: int, state: int, now: int) -> bool:
        """Note a heartbeat; return whether the node had been missing."""
        watched = self._nodes.get(node)
        if watched is None:
            return False
        returned, watched.missing = watched.missing, False
        watched.received_at, watched.state, watched.grace = now, state, 0
        return returned

    def newly_missing(self, now: int) -> list[int]:
        """Return the nodes that have become missing since the last call."""
        lost = []
        for node, watched in self._nodes.items():
            if not watched.missing and now - watched.received_at > watched.limit + watched.grace:
                watched.missing, watched.state = True, None
                lost.append(node)
        return lost

    def state(self, node: int) -> int | None:
        return self._nodes[node].state

    @property
    def missing(self) -> list[int]:
        return [node for node, watched in self._nodes.items() if watched.missing]


Send = Callable[[int, bytes], None]
RESTART_PERIOD_NS = 1_000_000_000  # [ns] between two commands to start


class Sensor:
    """One finger: read and compared whenever it boots, then started."""

    def __init__(self, node: int, dictionary: ObjectDictionary, send: Send, *, is_master: bool) -> None:
        self.node = node
        self.difference = ""  # from its EDS, in words
        self._dictionary = dictionary
        self._send = send
        self._is_master = is_master
        self._started: int | None = None  # [ns] when it was last started
        self._reader: SdoReader | None = None
        self.is_verified = False

    def begin(self) -> None:
        self.difference, self.is_verified, self._started = "", False, None
        asked = network.essentials(self._dictionary)
        self._reader = SdoReader(asked, lambda data: self._send(network.SDO_REQUEST + self.node, data))

    def answer(self, data: bytes, now: int) -> None:
        if self._reader is not None:
            self._reader.answer(data, now)

    def serve(self, state: int | None, now: int) -> None:
        """Go on reading; start it when it is what it should be."""
        if self._reader is not None:
            self._reader.serve(now)
            if self._reader.is_done:
                self._compare(self._reader)
        is_asleep = self.is_verified and self._is_master and state not in (None, network.OPERATIONAL)
        if is_asleep and (self._started is None or now - self._started >= RESTART_PERIOD_NS):
            self._started = now
            self._send(network.NMT, bytes([network.START, self.node]))

    def _compare(self, reader: SdoReader) -> None:
        self._reader = None
        if reader.failed:
            self.begin()  # silent: the heartbeat consumer says so; ask on
            return
        for (index, sub), value in reader.values.items():
            wanted = network.wanted_value(self._dictionary, index, sub)
            if value != wanted:
                has = "does not exist" if value is None else f"is {value:#x}"
                self.difference = f"object {index:04X}sub{sub} {has}, its EDS says {wanted:#x}"
                return
        self.is_verified = True


class Sensors:
    """All fingers of a hand."""

    def __init__(
        self,
        nodes: Sequence[int],
        dictionary: ObjectDictionary,
        limit: int,  # [ns] longest time between two heartbeats
        first: int,  # [ns] that a finger may take to appear
        send: Send,
        now: int,
        *,
        is_master: bool,
    ) -> None:
        self.consumer = HeartbeatConsumer(dict.fromkeys(nodes, limit), now, first)
        self.all = {node: Sensor(node, dictionary, send, is_master=is_master) for node in nodes}
        for sensor in self.all.values():
            sensor.begin()

    def receive(self, can_id: int, data: bytes, now: int) -> None:
        service, node = can_id & 0x780, can_id & 0x7F
        sensor = self.all.get(node)
        if sensor is None or not data:
            return
        if service == network.SDO_ANSWER:
            sensor.answer(data, now)
        elif service == network.HEARTBEAT:
            state = data[0] & 0x7F
            if self.consumer.take_heartbeat(node, state, now) or state == network.INITIALISING:
                sensor.begin()

    def serve(self, now: int) -> list[int]:
        """Go on with what is under way; return the nodes that have become missing."""
        for node, sensor in self.all.items():
            sensor.serve(self.consumer.state(node), now)
        return self.consumer.newly_missing(now)

    @property
    def is_ready(self) -> bool:
        return all(
            sensor.is_verified and self.consumer.state(node) == network.OPERATIONAL
            for node, sensor in self.all.items()
        )
