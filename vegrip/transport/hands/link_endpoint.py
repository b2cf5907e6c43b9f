"""Endpoint of a device that speaks packets over UDP, TCP or a serial line, opened as its map says."""

import contextlib
import select
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from vegrip.clock import NS
from vegrip.config import build, parameter
from vegrip.errors import ConfigError, DeviceError, suggestion
from vegrip.messages import Message
from vegrip.transport.byte_link import LINK_KINDS, Link, Open, opener, remedy
from vegrip.transport.codec import Frame
from vegrip.transport.endpoint import Endpoint, losses
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.commands import Outgoing
from vegrip.transport.mapped.compiled import compile_raw
from vegrip.transport.mapped.plan import Plan, open_plan
from vegrip.transport.mapped.price import price
from vegrip.transport.maps.conditions import Conditions, fields_of
from vegrip.transport.maps.dialogue import DeviceMap, Dialogue, Step, steps
from vegrip.transport.maps.packets import Index, Packet, on_streams
from vegrip.transport.open import Hand
from vegrip.transport.sender_clock import ClockEstimate, SenderClock

MOST_ENDS: Final = 2  # that are looked at for one beginning, should one stand in its data
MOST_RECORDS: Final = 64  # in an index
WAIT: Final = "wait"


class PacketStream:
    """The packets of one device."""

    def __init__(self, packets: Sequence[Packet], counts: Counter[str]) -> None:
        self._packets = packets
        self._counts = counts
        self._buffer = bytearray()
        self._is_lost = False
        self.skipped = 0
        """Bytes that belong to no packet."""
        self._keep = max((packet.reach for packet in packets), default=1) - 1
        self._clocks = {packet.name: (SenderClock(), [-1, 0]) for packet in packets if packet.clock}

    @property
    def clocks(self) -> list[SenderClock]:
        return [clock for clock, _ in self._clocks.values()]

    @property
    def pending(self) -> int:
        return len(self._buffer)

    def reset(self) -> None:
        self._buffer.clear()

    def feed(self, chunk: bytes, stamp: int) -> list[Frame]:
        """Return the packets that are whole with ``chunk``, which came at ``stamp`` [ns]."""
        buffer = self._buffer
        buffer += chunk
        found: list[Frame] = []
        at, length = 0, len(buffer)
        while at < length:
            packet, size = self._next(buffer, at)
            if packet is None:
                if size < 0:  # more is needed
                    break
                self._is_lost = True
                self.skipped += size
                at += size
                continue
            if self._is_lost:
                self._counts["resync"] += 1
                self._is_lost = False
            self._bring(packet, bytes(buffer[at : at + size]), stamp, found)
            at += size
        del buffer[:at]
        return found

    def datagram(self, data: bytes, stamp: int) -> list[Frame]:
        """Return the packet that is ``data`` as a whole; it came at ``stamp`` [ns]."""
        found: list[Frame] = []
        said = "unknown_packet"
        for packet in self._packets:
            if packet.start.match(data) is None:
                continue
            said = _flaw(packet, data)
            if not said:
                self._bring(packet, data, stamp, found)
                return found
        self._counts[said] += 1
        return found

    def _next(self, buffer: bytearray, at: int) -> tuple[Packet | None, int]:
        """Return the packet at ``at`` and its size; without one, how far to go on, or -1 to wait."""
        nearest, waits = len(buffer), False
        for packet in self._packets:
            match = packet.start.search(buffer, at)
            if match is None:
                continue
            if match.start() > at:
                nearest = min(nearest, match.start())
                continue
            size, said = _measure(packet, buffer, at)
            if size:
                return packet, size
            if said == WAIT:
                waits = True
                continue
            self._counts[said] += 1
            nearest = min(nearest, at + 1)
        if waits:
            return None, -1
        if nearest == len(buffer):  # the beginning of one may be cut
            nearest -= min(self._keep, nearest - at)
            if nearest == at:
                return None, -1
        return None, nearest - at

    def _bring(self, packet: Packet, data: bytes, stamp: int, found: list[Frame]) -> None:
        if packet.line is not None:
            fields = packet.line.fields(data)
            if fields is None:
                self._counts["bad_line"] += 1
                return
            data = fields
        if packet.clock is not None:
            read, modulus, per_count = packet.clock  # of the device, whose count is carried on where it wraps
            clock, ticks = self._clocks[packet.name]
            raw = read(data, 0)
            ticks[1] += (raw - ticks[0]) % modulus if ticks[0] >= 0 else raw
            ticks[0] = raw
            stamp = clock.observe(round(ticks[1] * per_count), stamp)
        if packet.index is None:
            found.append(Frame(packet.number, data, False, stamp))
            return
        for kind, begin in _records(packet.index, data):
            record = packet.records.get(kind)
            if kind < 0:
                self._counts["bad_record"] += 1
            elif record is None:
                continue
            elif len(data) - begin < record.least or record.start.match(data, begin) is None:
                self._counts["bad_record"] += 1
            else:
                found.append(Frame(record.number, data[begin:], False, stamp))


def _records(index: Index, data: bytes) -> Iterator[tuple[int, int]]:
    """Yield type and first byte of each record; type -1 ends an index that points at nothing."""
    at, first = index.at, len(data)
    for _ in range(MOST_RECORDS):
        if at + index.entry > first:
            if index.sizes and at < first:
                yield -1, at
            return
        kind, begin = index.type(data, at) & index.mask, at
        if index.offset is None:
            at += index.sizes.get(kind, first)
            is_sound = at <= first
        else:
            begin = index.origin + index.offset(data, at)
            at += index.entry
            is_sound = at <= begin < len(data)
            first = min(first, begin)
        yield (kind if is_sound else -1), begin
        if not is_sound:
            return


def _measure(packet: Packet, buffer: bytearray, at: int) -> tuple[int, str]:
    """Return the size of the sound packet at ``at``, or 0 and what it is instead."""
    rest = len(buffer) - at
    if packet.end and packet.size is None and packet.least != packet.most:
        return _up_to_end(packet, buffer, at)
    if rest < packet.least:
        return 0, WAIT
    size = packet.least if packet.size is None else packet.size(buffer, at)
    if not packet.least <= size <= packet.most:
        return 0, "bad_length"
    if rest < size:
        return 0, WAIT
    said = _flaw(packet, bytes(buffer[at : at + size]))
    return (0, said) if said else (size, "")


def _up_to_end(packet: Packet, buffer: bytearray, at: int) -> tuple[int, str]:
    look = at + packet.least - len(packet.end)
    last = at + packet.most
    said = "bad_end"
    for _ in range(MOST_ENDS):
        look = buffer.find(packet.end, look, last)
        if look < 0:
            return (0, WAIT) if len(buffer) < last else (0, said)
        size = look + len(packet.end) - at
        said = _flaw(packet, bytes(buffer[at : at + size]))
        if not said:
            return size, ""
        look += 1
    return 0, said


def _flaw(packet: Packet, data: bytes) -> str:
    """Return what is wrong with the whole packet ``data``, '' when nothing is."""
    length = len(data)
    if length < packet.least:
        return "short"
    wanted = length if packet.size is None else packet.size(data, 0)
    if length != wanted or length > packet.most:
        return "short" if length < wanted else "long"
    if not data.endswith(packet.end):
        return "bad_end"
    guard, index = packet.guard(length), packet.index
    if guard is not None:
        return "" if guard.check(data) else "bad_checksum"
    is_filled = index is None or not index.sizes or all(kind >= 0 for kind, _ in _records(index, data))
    return "" if is_filled else "bad_record"  # its only protection: the records fill it


MOST_CHUNKS: Final = 64  # taken in one go; a babbling device must not keep the loop from its ticks
REOPEN_PERIOD: Final = NS  # [ns] between two attempts to open a lost device
NOT_READY: Final = (
    "it is sent no command, and the force cannot change; see that nothing falls, and start the node again, "
    "which may move its jaws"
)
MOST_SPACING: Final = NS // 50  # [ns] between packets that come at once


@dataclass(frozen=True)
class LinkSettings:
    """``[transport]`` with ``kind = "udp"``, ``"tcp"`` or ``"serial"``."""

    kind: str = parameter("serial", choices=LINK_KINDS)
    address: Any = parameter("", doc="HOST:PORT or path of a tty; several where the map has several devices")
    baud: int = parameter(115_200, unit="bit/s", low=50, high=4_000_000, doc="of a serial line")
    local_port: int = parameter(0, low=0, high=65535, doc="that the device sends to; 0: any")
    map: str = parameter("", doc="file that describes its packets")


class Device:
    """One device: its link, its packets, what is said to it. Lost links are opened again and again."""

    def __init__(
        self, link: Link, open_: Open, stream: PacketStream, dialogue: Dialogue, counts: Counter[str]
    ) -> None:
        self.stream, self.dialogue = stream, dialogue
        self.link: Link | None = link
        self._open = open_
        self._counts = counts
        self._is_ready = False
        self._reopen_at = 0
        self.missed_when_ready = -1
        """Answers, up to when it last said whether it is ready: since another it may have been reset."""
        self._arrived_at = time.monotonic_ns()

    def read(self, now: int) -> list[tuple[Frame, int]]:
        """Return the packets that have come, each with the time of its arrival [ns]."""
        found: list[tuple[Frame, int]] = []
        if self.link is None:
            return []
        read = self.stream.datagram if self.link.is_datagram else self.stream.feed
        is_known = True
        try:
            for _ in range(MOST_CHUNKS):
                chunk = self.link.read()
                if not chunk:
                    break
                self.dialogue.take_in(chunk, now)
                at = self.link.arrived or now
                is_known = is_known and self.link.arrived > 0
                found += [(frame, at) for frame in read(chunk, at)]
                if not self.link.is_datagram and len(found) > MOST_CHUNKS:
                    break
        except OSError:
            self._lose(now)
        if not found or is_known:
            return found
        spacing = min((now - self._arrived_at) // len(found), MOST_SPACING)
        self._arrived_at = now
        last = len(found) - 1
        spread = ((frame, now - (last - place) * spacing) for place, (frame, _) in enumerate(found))
        return [(frame._replace(stamp=at) if frame.stamp == now else frame, at) for frame, at in spread]

    def talk(self, now: int) -> None:
        """Say what is due; open a link that was lost."""
        if self.link is None:
            self._reopen(now)
        if self.link is None:
            return
        if self.dialogue.is_silent(now) and self.link.is_connection:
            self._lose(now)
            return
        try:
            if not self._is_ready:
                if not self.link.is_ready():
                    return
                self._is_ready = True
                self.dialogue.start()
        except OSError:
            self._lose(now)
            return
        missed = self.dialogue.missed
        for step in self.dialogue.due(now):
            self.write(step.data, now)
        if self.dialogue.missed > missed:
            self.stream.reset()

    def write(self, data: bytes, now: int) -> None:
        """Send ``data`` now, or count it as unsent."""
        if self.link is None or not self._is_ready:
            self._counts["unsent"] += 1
            return
        try:
            self.link.write(data)
        except BlockingIOError:
            self._counts["unsent"] += 1
        except OSError:
            self._counts["unsent"] += 1
            if not self.link.is_datagram:
                self._lose(now)

    def close(self) -> None:
        """Say what is said at the end, and give the link back."""
        if self.link is None:
            return
        for step in self.dialogue.closing:
            with contextlib.suppress(OSError):
                self.link.write(step.data)
        with contextlib.suppress(OSError):
            self.link.close()
        self.link = None

    def _lose(self, now: int) -> None:
        self._counts["link_lost"] += 1
        if self.link is not None and self.link.is_datagram:
            return  # what comes back is that no program listened; there is no link to lose
        with contextlib.suppress(OSError):
            if self.link is not None:
                self.link.close()
        self.link, self._is_ready, self._reopen_at = None, False, now + REOPEN_PERIOD
        self.stream.reset()

    def _reopen(self, now: int) -> None:
        if now < self._reopen_at:
            return
        self._reopen_at = now + REOPEN_PERIOD
        with contextlib.suppress(OSError):
            self.link = self._open(False)


class MappedLinkEndpoint(Endpoint):
    """Packets of a foreign hand in and out.

    After opening nothing raises. Besides the names of the codec ``rejected`` has those of
    :class:`~vegrip.transport.hands.link_endpoint.PacketStream`, of
    :class:`~vegrip.transport.maps.dialogue.Dialogue`, ``link_lost``, ``unsent``, ``silent``,
    ``not_ready`` (looks at a command that waits for a device which is not), and ``command_held`` (commands
    repeated after their lifetime).
    """

    def __init__(self, links: Sequence[tuple[Link, Open]], codec: MappedCodec) -> None:
        self.arrivals: Sequence[int] = ()
        self._codec, self.broken = codec, codec.broken
        self._faults: Counter[str] = Counter()
        plan = codec.plan
        self._conditions = _conditions(plan, self._faults)
        self._orders, self._ready = _orders(plan), plan.hand.device.ready
        self.hints = {"not_ready": f"{plan.hand.path.stem} is no longer {self._ready!r}: {NOT_READY}"}
        self._was_ready = False
        self._lines = {packet.name: packet.line for packet in plan.database.packets}
        self._counted = {name: each.counted for name, each in plan.hand.packets.items() if each.counted}
        self._device_of = {packet.number: packet.device for packet in plan.database.packets}
        self._of = {packet.number: packet.name for packet in plan.database.packets}
        self._of |= {
            record.number: packet.name
            for packet in plan.database.packets
            for record in packet.records.values()
        }
        self._devices = [
            Device(link, open_, self._stream(number), self._dialogue(number), self._faults)
            for number, (link, open_) in enumerate(links)
        ]

    def _stream(self, device: int) -> PacketStream:
        plan = self._codec.plan
        packets = [one for one in plan.database.packets if one.device == device and _is_read(plan, one.name)]
        return PacketStream(packets, self._faults)

    def _dialogue(self, device: int) -> Dialogue:
        hand = self._codec.plan.hand
        return Dialogue(
            hand.device,
            device,
            hand.command.period,
            self._faults,
            str(hand.path),
            holds=self.conditions.__contains__,
        )

    @property
    def conditions(self) -> Set[str]:
        """Which of ``[conditions]`` of the map hold now; those that are faults are counted as they begin."""
        return self._conditions.now

    @property
    def obeys(self) -> bool:
        is_refused = any(map(self._is_refused, self._orders.values()))
        return not is_refused and all(self._obeys(device) for device in self._devices)

    @property
    def device_faults(self) -> Set[tuple[str, str]]:
        return {(str(self._codec.plan.hand.path), name) for name in self._conditions.faults}

    def begin(self, address: str) -> None:
        """Go through the opening of a device that has to be ``ready``.

        Raises:
            DeviceError: it does not answer as the map says, or is not ready in time; in one sentence.

        """
        device = self._codec.plan.hand.device
        if not device.ready:
            return
        deadline = time.monotonic() + device.patience
        while device.ready not in self.conditions or not all(one.dialogue.is_open for one in self._devices):
            if time.monotonic() > deadline:
                raise DeviceError(f"the device at {address} {self._unready(device)}")
            self.receive(0.01)
        self._was_ready = True

    def _unready(self, device: DeviceMap) -> str:
        if not self.heard:
            noise = ", ".join(f"{name} {count}" for name, count in self.rejected.items())
            return (
                f"does not answer as {self._codec.plan.hand.path} says within {device.patience:g} s "
                f"({noise}): is it that device, on, and are its rate and number those of the map?"
            )
        holding = ", ".join(sorted(self.conditions)) or "nothing"
        return (
            f"answers, but is not {device.ready!r} within {device.patience:g} s; it says of itself: {holding}"
        )

    @property
    def sentences(self) -> Sequence[str]:
        return price(self._codec.plan)

    @property
    def descriptors(self) -> Sequence[int]:
        return [device.link.fileno() for device in self._devices if device.link is not None]

    @property
    def skipped(self) -> int:
        """Bytes that have come and belong to no packet of the map."""
        return sum(device.stream.skipped for device in self._devices)

    @property
    def rejected(self) -> Mapping[str, int]:
        held = {"command_held": self._codec.encoder.held}
        found = {**self._codec.rejected, **self._faults, **losses(self._codec), **held}
        return {name: count for name, count in found.items() if count}

    @property
    def clock(self) -> ClockEstimate | None:
        """The clock of the first device, or of the interface it is at, against ours; None: none is sent."""
        clocks = [clock for device in self._devices for clock in device.stream.clocks]
        clocks += [
            one.link.clock for one in self._devices if one.link is not None and one.link.clock is not None
        ]
        return clocks[0].estimate() if clocks else None

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a state, then take what is there; say what is due."""
        deadline = time.monotonic_ns() + round(timeout * NS)
        messages: list[Message] = []
        arrivals: list[int] = []
        while True:
            now = time.monotonic_ns()
            self._say(now)
            ready = self._wait(min(deadline, self._next_at) - now)
            now = time.monotonic_ns()
            for device in ready:
                for frame, arrival in device.read(now):
                    self._hear(device, frame, now)
                    states = self._codec.decode_all(frame)
                    messages += states
                    arrivals += [arrival] * len(states)
            if messages or now >= deadline:
                break
        self._say(time.monotonic_ns())
        self._codec.add_reports(messages, arrivals, now)
        self.arrivals = arrivals
        return messages

    def send(self, message: Message) -> None:
        """Send a command; other messages are not for a foreign hand."""
        now = time.monotonic_ns()
        for frame in self._codec.encode(message):
            self._send_frame(frame, now)
        if self._orders:
            self._say(now)

    def zero(self) -> bool:
        asked = [device.dialogue.zero() for device in self._devices]
        return any(asked)

    def close(self) -> None:
        for device in self._devices:
            device.close()

    @property
    def _next_at(self) -> int:
        return min(
            (device.dialogue.next_at for device in self._devices if device.link is not None), default=1 << 62
        )

    def _say(self, now: int) -> None:
        for device in self._devices:
            device.talk(now)
        for frame in self._codec.due(now):
            self._send_frame(frame, now)
        for outgoing in self._codec.encoder.wanted():
            identifier = self._codec.plan.database.messages[outgoing.name].identifier
            device = self._devices[self._device_of[identifier]]
            if self._was_ready and self._ready not in self._conditions.now and not device.dialogue.is_begun:
                self._faults["not_ready"] += 1
            device.dialogue.order(outgoing.name, partial(self._made, outgoing, device))
            device.talk(now)

    def _send_frame(self, frame: Frame, now: int) -> None:
        device = self._device_of.get(frame.arbitration_id, 0)
        if device < len(self._devices):
            self._devices[device].write(frame.data, now)

    def _obeys(self, device: Device) -> bool:
        """Whether the device is ready; to one that was reset a command may be an order to activate itself."""
        is_sure = device.missed_when_ready == device.dialogue.missed
        return not self._ready or (is_sure and self._ready in self._conditions.now)

    def _is_refused(self, order: "_Order") -> bool:
        """Whether what answered a command says a fault: its device has not done it."""
        faults = self._conditions.faults
        return any(self._conditions.judges(each, fault) for each in order.answers for fault in faults)

    def _made(self, outgoing: Outgoing, device: Device, now: int) -> list[Step]:
        """Return the command of now, with what follows where it is new, or was not done or received."""
        outgoing.is_wanted, dialogue = False, device.dialogue
        if not self._obeys(device):
            return []
        order, line = self._orders[outgoing.name], self._lines.get(outgoing.name)
        found = []
        for frame in outgoing.message(now):
            command = outgoing.targets[0].command
            opens = bool(order.opened) and command is not None and command.normal_force <= 0.0
            said = frame.data, opens, dialogue.starts, dialogue.missed
            is_new, order.said = said != order.said or self._is_refused(order), said
            order.answers = [one.expects for one in (order.opened if opens else (order.step, *order.then))]
            if opens:
                return list(order.opened) if is_new else []
            data = frame.data if line is None else line.line(frame.data)
            found += [order.step._replace(data=data), *(order.then if is_new else ())]
        return found

    def _hear(self, device: Device, frame: Frame, now: int) -> None:
        name = self._of.get(frame.arbitration_id, "")
        self.heard = now
        self._conditions.take(name, frame.data)
        if self._conditions.judges(name, self._ready):
            device.missed_when_ready = device.dialogue.missed
        if name in self._counted:
            self._faults[self._counted[name]] += 1
        device.dialogue.came(name, now)

    def _wait(self, nanoseconds: int) -> list[Device]:
        waiting = [(device, device.link) for device in self._devices if device.link is not None]
        seconds = max(nanoseconds, 0) / NS
        if not waiting:
            time.sleep(min(seconds, 0.01))
            return []
        ready = select.select([link for _, link in waiting], [], [], seconds)[0]
        return [device for device, link in waiting if link in ready]


def _is_read(plan: Plan, packet: str) -> bool:
    commands = {
        finger.command.signal.partition(".")[0]
        for finger in plan.hand.fingers.values()
        if finger.command is not None
    }
    return packet in plan.messages or packet not in commands


def _conditions(plan: Plan, counts: Counter[str]) -> Conditions:
    messages, maps, device = plan.database.messages, plan.hand.conditions, plan.hand.device
    for name in sorted(device.conditions.difference(maps)):
        hint = suggestion(name, maps, "there are")
        raise ConfigError(f"{plan.hand.path} [device]: there is no condition {name!r}; {hint}")
    needed = fields_of(maps, {name: one.signals for name, one in messages.items()}, str(plan.hand.path))
    readers = {
        packet: {field: compile_raw(messages[packet], messages[packet].signals[field]) for field in fields}
        for packet, fields in needed.items()
    }
    return Conditions(maps, readers, counts)


@dataclass(slots=True)
class _Order:
    """How a command leaves that its device answers."""

    step: Step
    then: Sequence[Step]
    opened: Sequence[Step]
    said: Any = None  # the last command, and how often the device was lost before
    answers: Sequence[str] = ()  # the packets that answer it


def _orders(plan: Plan) -> dict[str, _Order]:
    found = {}
    for name, each in plan.hand.packets.items():
        if each.answer:
            where = f"{plan.hand.path} [packets.{name}]"
            entries = [{"data": "00", "expects": each.answer}], each.then, each.opened
            (step,), then, opened = (steps(one, each.device, 0.0, None, where) for one in entries)
            found[name] = _Order(step, then, opened)
    return found


def open_link(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """Open the devices of a hand on lines of their own."""
    settings = build(LinkSettings, table, where)
    if not settings.map:
        raise ConfigError(
            f"{where}: kind = {settings.kind!r} needs map = 'hand.toml', which describes the packets"
        )
    plan = open_plan(settings.map, hand.fingers)
    packets = plan.database.packets
    if not packets:
        raise ConfigError(
            f"{settings.map}: describes no packets; over {settings.kind} a map has [packets.NAME]"
        )
    if settings.kind != "udp":
        on_streams(packets)
    addresses = settings.address if isinstance(settings.address, (list, tuple)) else [settings.address]
    wanted = max(packet.device for packet in packets) + 1
    if len(addresses) != wanted or not all(isinstance(one, str) for one in addresses):
        raise ConfigError(
            f"{where}: 'address' is {settings.address!r}; the map has {wanted} devices, so give {wanted}"
        )
    made = [opener(settings.kind, one, settings.baud, settings.local_port, where) for one in addresses]
    codec = MappedCodec(plan)
    links: list[tuple[Link, Open]] = []
    for address, open_ in zip(addresses, made, strict=True):
        try:
            links.append((open_(True), open_))
        except OSError as error:
            for link, _ in links:
                link.close()
            raise DeviceError(remedy(settings.kind, address, error)) from None
    endpoint = MappedLinkEndpoint(links, codec)
    try:
        endpoint.begin(", ".join(addresses))
    except DeviceError:
        endpoint.close()
        raise
    return endpoint
