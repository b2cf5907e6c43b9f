"""Every wire of the product, opened by its ``[transport]`` table, with the events of a case at its end.

A wire makes bytes of events once, brings them to the endpoint at their times, and keeps what it sends.
"""

import os
import socket
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import can
import can.interfaces

from validation.bus_bytes import delivery_of, split_requests
from validation.faults.simulated_bus import Transmission
from validation.golden import world
from validation.golden.events import FOREIGN, STATE, Event
from validation.golden.foreign import ForeignHand
from validation.golden.settings import Setting
from validation.golden.world import Item
from validation.liars import DATA_IDS, Liar, PartLiar, PayloadLiar
from vegrip.canopen.endpoint import CanopenEndpoint
from vegrip.canopen.network import identifiers
from vegrip.messages import FingertipState, Message
from vegrip.transport.canbus import virtual_can
from vegrip.transport.canbus.frame_time import FD_SIZES, BusFrame
from vegrip.transport.canbus.hub_wire import MAX_GATHERED_BYTES
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.batch_codec import BATCHED_MESSAGES, BatchCodec
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint

PART_NS = 130_000  # [ns] between the frames that make one state
TOGETHER_NS = 2_000_000  # [ns] states of one sample come within
UNKNOWN_ID = 0x7FF
Sent = tuple[int, str, bytes]
"""Time [ns], identifier or topic, and bytes."""


def state_of(event: Event, fingers: Sequence[str]) -> FingertipState:
    """Return the message of a state."""
    return FingertipState(event.sent, fingers[event.finger], event.seq, *event.values)


def harmed(data: bytes, harm: int) -> bytes:
    """Return ``data`` with one bit flipped, or cut short."""
    if harm > 0:
        broken, bit = bytearray(data), (harm - 1) % (8 * len(data))
        broken[bit // 8] ^= 1 << bit % 8
        return bytes(broken)
    return data[: min(-harm, len(data) // 2)] if harm else data


def sized(frame: Frame) -> Frame:
    """Return a frame of a length that CAN FD has, cut shorter if need be."""
    if not frame.fd or len(frame.data) in FD_SIZES:
        return frame
    return frame._replace(data=frame.data[: max(size for size in FD_SIZES if size < len(frame.data))])


class Wire:
    """One kind of wire between a hand with ``fingers`` and the node, for one case."""

    has_order = False  # whether its table knows ``order_window``
    has_clock = False  # whether it knows ``estimate_clock``
    has_sender = False  # whether it knows ``sender_time``
    tells_stamps = True  # whether what is sent carries its time

    def __init__(self, fingers: tuple[str, ...], setting: Setting) -> None:
        self.fingers, self.setting = fingers, setting
        self.sent: list[Sent] = []

    def items(self, events: Iterable[Event]) -> list[Item]:
        """Return what arrives."""
        found: list[Item] = []
        for event in events:
            if event.kind == STATE:
                found += self.of_state(event)
            elif event.kind == FOREIGN:
                found += self.of_nobody(event)
            else:
                found.append(Item(event.now, event, True))
        return sorted(found, key=lambda item: item.now)

    def of_state(self, event: Event) -> list[Item]:
        """Return what brings a state."""
        raise NotImplementedError

    def of_nobody(self, event: Event) -> list[Item]:
        """Return what is not for this node."""
        raise NotImplementedError

    def falsified(self, items: list[Item], seed: int) -> list[Item]:
        """Return the bytes made false on this wire alone."""
        del seed
        return items

    def deliver(self, item: Item) -> None:
        """Bring what arrives to the endpoint."""
        raise NotImplementedError

    def open(self) -> Endpoint:
        """Open the endpoint of the node."""
        raise NotImplementedError

    def collect(self) -> None:
        """Take what the endpoint has sent, where it does not come by itself."""

    def decoded(self, sent: Iterable[Sent]) -> Iterable[tuple[int, Message]]:
        """Yield what was said, with its time."""
        raise NotImplementedError

    def close(self, endpoint: Endpoint) -> None:
        """Close the endpoint."""
        endpoint.close()


class ScriptedBus(can.BusABC):
    """A bus of python-can whose frames are those of a case."""

    last: "ScriptedBus"
    on_sent: Callable[[can.Message], None]

    def __init__(self, channel: Any = None, **_: Any) -> None:
        super().__init__(channel)
        self.inbox: deque[can.Message] = deque()
        ScriptedBus.last = self

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame."""
        if not self.inbox and timeout:
            world.wait(timeout)
        return self.inbox.popleft() if self.inbox else None

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Keep what is sent."""
        del timeout
        ScriptedBus.on_sent(msg)


class Frames(Wire):
    """Frames of our own layout on a bus of python-can."""

    fd = True
    has_order = True
    has_clock = has_sender = True

    def __init__(self, fingers: tuple[str, ...], setting: Setting) -> None:
        super().__init__(fingers, setting)
        self._encoder = CanCodec(fingers, fd=self.fd)

    def table(self) -> dict[str, Any]:
        """Return the table ``[transport]``."""
        setting = self.setting
        found: dict[str, Any] = {"kind": "can", "interface": "virtual", "channel": "golden", "fd": self.fd}
        if setting.order_window:
            found["order_window"] = setting.order_window
        if setting.sender_time is not None:
            found["sender_time"] = setting.sender_time
        if setting.estimate_clock:
            found["estimate_clock"] = True
        return found

    def of_state(self, event: Event) -> list[Item]:
        """Return its frames."""
        frames = self._encoder.encode(state_of(event, self.fingers))
        hit = (event.harm - 1) % len(frames) if event.harm > 0 else 0
        found = []
        for number, frame in enumerate(frames):
            harm = event.harm if event.harm < 0 or number == hit else 0
            later = PART_NS * number
            sent = frame._replace(data=harmed(frame.data, harm), stamp=event.stamp + later)
            found.append(Item(event.now + later, sent))
        return found

    def of_nobody(self, event: Event) -> list[Item]:
        """Return a frame with an identifier that no node has."""
        return [Item(event.now, Frame(UNKNOWN_ID, bytes(8), self.fd, event.stamp))]

    def falsified(self, items: list[Item], seed: int) -> list[Item]:
        """Return false frames of states; checksums fit, mostly."""
        liars: dict[int, Any] = {}
        found = []
        for item in items:
            if item.happens:
                found.append(item)
                continue
            frame, later = item.thing, 0
            for delay, sent in self._false(liars, frame, seed):
                later += delay
                found.append(Item(item.now + later, sent._replace(stamp=sent.stamp + later)))
        return sorted(found, key=lambda item: item.now)

    def _false(self, liars: dict[int, Any], frame: Frame, seed: int) -> Sequence[tuple[int, Frame]]:
        number = frame.arbitration_id
        if self.fd:
            if 0x200 <= number < 0x240:
                liar = liars.setdefault(number, Liar((seed, number)))
                return ((0, frame._replace(data=liar.falsified(frame, 0))),)
        elif number in DATA_IDS:
            result: Sequence[tuple[int, Frame]] = liars.setdefault(
                number & 7, PartLiar((seed, number & 7))
            ).falsified(frame)
            return result
        return ((0, frame),)

    def open(self) -> Endpoint:
        """Open it on the scripted bus."""
        ScriptedBus.on_sent = self._keep
        backends = can.interfaces.BACKENDS
        usual, backends["virtual"] = backends["virtual"], (__name__, "ScriptedBus")  # takes no new names
        try:
            return open_endpoint(self.table(), Hand(self.fingers))
        finally:
            backends["virtual"] = usual

    def deliver(self, item: Item) -> None:
        """Put a frame into the inbox of the bus."""
        frame: Frame = sized(item.thing)
        message = can.Message(
            timestamp=frame.stamp / world.NS, arbitration_id=frame.arbitration_id, is_extended_id=False,
            is_fd=frame.fd, data=frame.data,
        )  # fmt: skip
        ScriptedBus.last.inbox.append(message)

    def _keep(self, message: can.Message) -> None:
        at = world.now()
        self.sent.append((at, f"{message.arbitration_id:03x}", bytes(message.data)))

    def decoded(self, sent: Iterable[Sent]) -> Iterable[tuple[int, Message]]:
        """Yield what the frames say."""
        codec = CanCodec(self.fingers, fd=self.fd, use_sender_time=self.fd)
        for at, stream, data in sent:
            message = codec.decode(Frame(int(stream, 16), data, self.fd, at))
            if message is not None:
                yield at, message


class Classic(Frames):
    """Classic frames."""

    fd = False
    has_clock = has_sender = False


class Canopen(Classic):
    """The PDOs of CANopen, of fingers that are found and operational."""

    has_order = False
    NODES, GRASP = 32, 16

    def __init__(self, fingers: tuple[str, ...], setting: Setting) -> None:
        super().__init__(fingers, setting)
        nodes = tuple(self.NODES + number for number in range(len(fingers)))
        self._classic = dict(identifiers(nodes, self.GRASP, 0))
        self._cob = {identifier: cob_id for cob_id, identifier in self._classic.items()}

    def deliver(self, item: Item) -> None:
        """Put a PDO into the inbox of the bus."""
        frame: Frame = item.thing
        number = self._cob.get(frame.arbitration_id, frame.arbitration_id)
        super().deliver(Item(item.now, frame._replace(arbitration_id=number)))

    def open(self) -> Endpoint:
        """Open an end that hears and says all PDOs."""
        ScriptedBus.on_sent = self._keep
        codec = CanCodec(self.fingers, fd=False)
        return PdoEndpoint(ScriptedBus(), codec, self._classic)

    def close(self, endpoint: Endpoint) -> None:
        """Close the bus; the endpoint would wait for what it has queued."""
        endpoint.can.close()  # type: ignore[attr-defined]

    def decoded(self, sent: Iterable[Sent]) -> Iterable[tuple[int, Message]]:
        """Yield what the PDOs say."""
        known = [
            (at, f"{self._classic.get(int(stream, 16), UNKNOWN_ID):03x}", data) for at, stream, data in sent
        ]
        return super().decoded(known)


class PdoEndpoint(CanopenEndpoint):
    """An endpoint that hears and says everything."""

    def speaks(self, cob_id: int) -> bool:  # noqa: ARG002
        """Say everything."""
        return True


class Packets(Frames):
    """CAN FD on the virtual bus, which brings frames that end together in one packet."""

    has_order = has_clock = False

    def items(self, events: Iterable[Event]) -> list[Item]:
        """Return packets: states of one sample in one."""
        return together(super().items(events))

    def falsified(self, items: list[Item], seed: int) -> list[Item]:
        """Return packets of false frames."""
        single = [
            single
            for item in items
            for single in ([item] if item.happens else [Item(item.now, frame) for frame in item.thing])
        ]
        return together(super().falsified(single, seed))

    def table(self) -> dict[str, Any]:
        """Return the table ``[transport]``."""
        return super().table() | {"interface": "vegrip"}

    def open(self) -> Endpoint:
        """Open it with the other end of the bus in our hands."""
        near, self._far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        near.setblocking(False)
        self._far.setblocking(False)
        self._number, self._busy = 0, 0
        join, answer = virtual_can._join, {"node": 1, "timing": {}, "busy": 0}
        virtual_can._join = lambda *_: (near, answer)
        try:
            return open_endpoint(self.table(), Hand(self.fingers))
        finally:
            virtual_can._join = join

    def deliver(self, item: Item) -> None:
        """Send a packet."""
        packet = b""
        for frame in map(sized, item.thing):
            self._busy += 100_000
            sent = BusFrame(frame.arbitration_id, frame.data, fd=True, has_bit_rate_switch=True)
            packet += delivery_of(self._number, Transmission(0, frame.stamp, 2, sent), self._busy)
            self._number += 1
        self._far.send(packet)

    def collect(self) -> None:
        """Take the requests of the node."""
        while True:
            try:
                packet = self._far.recv(MAX_GATHERED_BYTES)
            except BlockingIOError:
                return
            if not packet:
                return
            at = world.now()
            self.sent += [(at, f"{frame.identifier:03x}", frame.data) for _, frame in split_requests(packet)]

    def close(self, endpoint: Endpoint) -> None:
        """Close both ends."""
        endpoint.close()
        self._far.close()


def together(items: Sequence[Item]) -> list[Item]:
    """Return items with the things of one sample in one: frames of different identifiers."""
    found: list[Item] = []
    for item in items:
        last = found[-1] if found else None
        if item.happens:
            found.append(item)
            continue
        fits = last is not None and not last.happens and item.now - last.thing[0].stamp < TOGETHER_NS
        if fits and len(last.thing) < 8 and not _has(last.thing, item.thing):  # type: ignore[union-attr]
            found[-1] = Item(item.now, [*last.thing, item.thing])  # type: ignore[union-attr]
        else:
            found.append(Item(item.now, [item.thing]))
    return found


def _has(frames: Sequence[Frame], frame: Frame) -> bool:
    return any(one.arbitration_id == frame.arbitration_id for one in frames)


class _Publisher:
    """What stands for the socket that publishes."""

    def __init__(self, keep: Callable[[bytes, bytes], None]) -> None:
        self._keep = keep
        self._topic = b""

    def send_multipart(self, parts: Sequence[bytes], _: int = 0) -> None:
        """Keep a message."""
        self._keep(bytes(parts[0]), bytes(parts[1]))

    def send(self, data: bytes, _: int = 0) -> None:
        """Keep topic and payload in turn."""
        if self._topic:
            self._keep(self._topic, bytes(data))
            self._topic = b""
        else:
            self._topic = bytes(data)


class _Subscription:
    """What stands for the publisher that is listened to."""

    cut_off = 0

    def __init__(self) -> None:
        self.inbox: deque[list[bytes]] = deque()

    def look(self, now: float) -> None:
        """Nothing is wrong with the connection."""

    def take(self) -> list[bytes] | None:
        """Return what has come."""
        return self.inbox.popleft() if self.inbox else None

    def close(self) -> None:
        """Nothing to release."""


class Topics(Wire):
    """msgpack on single topics of ZeroMQ."""

    has_sender = True
    batch = False

    def __init__(self, fingers: tuple[str, ...], setting: Setting) -> None:
        super().__init__(fingers, setting)
        self._encoder = MsgpackCodec("", fingers)

    def of_state(self, event: Event) -> list[Item]:
        """Return its topic and payload."""
        encoded = self._encoder.encode(state_of(event, self.fingers))
        if encoded is None:
            return []
        return [Item(event.now, [encoded[0].encode(), harmed(encoded[1], event.harm)])]

    def of_nobody(self, event: Event) -> list[Item]:
        """Return a topic that no node has."""
        return [Item(event.now, [b"/hand/elbow/state", b"nothing"])]

    def falsified(self, items: list[Item], seed: int) -> list[Item]:
        """Return false payloads of states; checksums fit, mostly."""
        topics = {f"/hand/{name}/state".encode(): name for name in self.fingers}
        liars = {name: PayloadLiar((seed, number), name) for number, name in enumerate(self.fingers)}
        found = []
        for item in items:
            name = "" if item.happens else topics.get(item.thing[0], "")
            if not name:
                found.append(item)
                continue
            payloads = liars[name].falsified(item.thing[1], 0)
            found += [Item(item.now, [item.thing[0], bytes(payload)]) for payload in payloads]
        return found

    def open(self) -> Endpoint:
        """Open it with both sockets in our hands."""
        table: dict[str, Any] = {"kind": "zmq", "publish": f"ipc:golden-{os.getpid()}", "batch": self.batch}
        if self.setting.sender_time is not None:
            table["sender_time"] = self.setting.sender_time
        return self.taken(open_endpoint(table, Hand(self.fingers)))

    def taken(self, opened: Endpoint) -> Endpoint:
        """Put ourselves in the place of the sockets of an endpoint."""
        endpoint: Any = opened
        self._real, endpoint._publisher = endpoint._publisher, _Publisher(self._keep)
        self._subscription = _Subscription()
        endpoint._subscriptions = [self._subscription]
        return opened

    def close(self, endpoint: Endpoint) -> None:
        """Close what was opened."""
        endpoint._publisher = self._real  # type: ignore[attr-defined]
        endpoint.close()

    def deliver(self, item: Item) -> None:
        """Bring a message."""
        self._subscription.inbox.append(item.thing)

    def _keep(self, topic: bytes, payload: bytes) -> None:
        self.sent.append((world.now(), topic.decode(), payload))

    def decoded(self, sent: Iterable[Sent]) -> Iterable[tuple[int, Message]]:
        """Yield what the payloads say."""
        codec = MsgpackCodec("", self.fingers)
        for at, topic, payload in sent:
            message = codec.decode(topic, payload, at)
            if message is not None:
                yield at, message


class Batches(Topics):
    """States of all fingers in one message of ZeroMQ, and their commands."""

    batch = True

    def __init__(self, fingers: tuple[str, ...], setting: Setting) -> None:
        super().__init__(fingers, setting)
        self._rows = BatchCodec(fingers)

    def items(self, events: Iterable[Event]) -> list[Item]:
        """Return batches: states of one sample in one."""
        frames = Frames.__new__(Frames)
        frames.fingers, frames._encoder = self.fingers, self._rows  # type: ignore[assignment]
        found = []
        for item in together(Wire.items(frames, events)):
            if item.happens:
                found.append(item)
            elif item.thing[0].arbitration_id == UNKNOWN_ID:
                found += self.of_nobody(Event(FOREIGN, item.now))
            else:
                found.append(self._batch(item))
        return found

    def _batch(self, item: Item) -> Item:
        length = self._rows.lengths[FingertipState]
        rows = [frame._replace(data=frame.data.ljust(length, b"\0")) for frame in item.thing]
        payload = bytes(self._rows.pack(FingertipState, rows))
        return Item(item.now, [self._rows.topics[FingertipState].encode(), payload])

    def falsified(self, items: list[Item], seed: int) -> list[Item]:
        """Return batches as they are: their rows are false by the events."""
        del seed
        return items

    def decoded(self, sent: Iterable[Sent]) -> Iterable[tuple[int, Message]]:
        """Yield what rows and payloads say."""
        codec = BatchCodec(self.fingers)
        kinds = {codec.topics[kind]: kind for kind in BATCHED_MESSAGES}
        single = MsgpackCodec("", self.fingers)
        for at, topic, payload in sent:
            kind = kinds.get(topic)
            if kind is None:
                message = single.decode(topic, payload, at)
                if message is not None:
                    yield at, message
                continue
            for row in range(codec.rows_in(payload, kind)):
                message = codec.decode(codec.frame(payload, kind, row, at))
                if message is not None:
                    yield at, message


class Mapped(Frames):
    """Frames of a hand of another make, by a map: two messages a state, with counter and checksum."""

    fd = False
    has_order = has_clock = has_sender = False
    tells_stamps = False

    def __init__(self, fingers: tuple[str, ...], setting: Setting) -> None:
        Wire.__init__(self, fingers, setting)
        self._foreign = ForeignHand(fingers)

    def table(self) -> dict[str, Any]:
        """Return the table ``[transport]``."""
        folder = Path(os.environ.get("GOLDEN_FOLDER", "build/golden")) / "foreign"
        return super().table() | {"map": str(self._foreign.written(folder))}

    def of_state(self, event: Event) -> list[Item]:
        """Return its frames."""
        frames = self._foreign.frames(event)
        hit = (event.harm - 1) % len(frames) if event.harm > 0 else 0
        return [
            Item(
                event.now + PART_NS * number,
                Frame(
                    identifier,
                    harmed(data, event.harm if event.harm < 0 or number == hit else 0),
                    False,
                    event.stamp + PART_NS * number,
                ),
            )
            for number, (identifier, data) in enumerate(frames)
        ]

    def falsified(self, items: list[Item], seed: int) -> list[Item]:
        """Return the frames as they are: they are false by the events."""
        del seed
        return items

    def decoded(self, sent: Iterable[Sent]) -> Iterable[tuple[int, Message]]:
        """Yield the forces that were asked for, as commands without a time."""
        for at, stream, data in sent:
            command = self._foreign.command(int(stream, 16), data, at)
            if command is not None:
                yield at, command


WIRES: dict[str, type[Wire]] = {
    "fd": Frames,
    "classic": Classic,
    "canopen": Canopen,
    "packet": Packets,
    "topics": Topics,
    "batch": Batches,
    "map": Mapped,
}
"""Those with an endpoint; ``messages`` and ``replay`` are in :mod:`validation.golden.play`."""
