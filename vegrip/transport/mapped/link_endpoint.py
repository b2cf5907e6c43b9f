"""Endpoint of a device that speaks packets over UDP, TCP or a serial line, opened as its map says."""

import contextlib
import math
import select
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from vegrip.clock import NS
from vegrip.config import build, parameter
from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import Message
from vegrip.transport.byte_link import LINK_KINDS, Link, Open, opener, remedy
from vegrip.transport.codec import Frame
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.losses import losses
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.dialogue import Dialogue
from vegrip.transport.mapped.packet_stream import PacketStream
from vegrip.transport.mapped.packets import on_streams
from vegrip.transport.mapped.plan import Plan, open_plan
from vegrip.transport.mapped.price import price
from vegrip.transport.open import Hand
from vegrip.transport.sender_clock import ClockEstimate

MOST_CHUNKS: Final = 64  # taken in one go; a babbling device must not keep the loop from its ticks
REOPEN_PERIOD: Final = NS  # [ns] between two attempts to open a lost device
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
    """One device: its link, its packets, what is said to it. Lost links are opened again and again.

    Args:
        link: to it.
        open_: opens it again.
        stream: its packets.
        dialogue: what is said to it.
        counts: shared with others; here ``link_lost``, ``unsent`` and ``silent``.

    """

    def __init__(
        self, link: Link, open_: Open, stream: PacketStream, dialogue: Dialogue, counts: Counter[str]
    ) -> None:
        self.stream, self.dialogue = stream, dialogue
        self.link: Link | None = link
        self._open = open_
        self._counts = counts
        self._is_ready = False
        self._reopen_at = 0
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
                self.dialogue.hear(chunk, now)
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
    :class:`~vegrip.transport.mapped.packet_stream.PacketStream`, of
    :class:`~vegrip.transport.mapped.dialogue.Dialogue`, ``link_lost``, ``unsent``, ``silent``, and
    ``command_held`` (commands repeated after their lifetime).
    """

    def __init__(self, links: Sequence[tuple[Link, Open]], codec: MappedCodec) -> None:
        self.arrivals: Sequence[int] = ()
        self._codec = codec
        self._faults: Counter[str] = Counter()
        plan = codec.plan
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
        return Dialogue(hand.device, device, hand.sending.period, self._faults, str(hand.path))

    @property
    def sentences(self) -> Sequence[str]:
        """What the owner of the hand must know before it grips."""
        return price(self._codec.plan)

    @property
    def rejected(self) -> Mapping[str, int]:
        """What went wrong so far, by name."""
        held = {"command_held": self._codec.encoder.held}
        found = {**self._codec.rejected, **self._faults, **losses(self._codec), **held}
        return {name: count for name, count in found.items() if count}

    @property
    def broken(self) -> Mapping[str, int]:
        """States that arrived and could not be understood, by finger."""
        return self._codec.broken

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
                    device.dialogue.came(self._of.get(frame.arbitration_id, ""))
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

    def zero(self) -> bool:
        """Have the devices take their zeros; whether the map has a command for that."""
        asked = [device.dialogue.zero() for device in self._devices]
        return any(asked)

    def bus_load(self) -> float:
        """Return NaN: the line is shared with no other."""
        return math.nan

    def close(self) -> None:
        """Say good-bye and give the lines back."""
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

    def _send_frame(self, frame: Frame, now: int) -> None:
        device = self._device_of.get(frame.arbitration_id, 0)
        if device < len(self._devices):
            self._devices[device].write(frame.data, now)

    def _wait(self, nanoseconds: int) -> list[Device]:
        waiting = [(device, device.link) for device in self._devices if device.link is not None]
        seconds = max(nanoseconds, 0) / NS
        if not waiting:
            time.sleep(min(seconds, 0.01))
            return []
        ready = select.select([link for _, link in waiting], [], [], seconds)[0]
        return [device for device, link in waiting if link in ready]


def _is_read(plan: Plan, packet: str) -> bool:
    """Whether the device sends ``packet``: it is none that only carries commands."""
    commands = {
        finger.command.signal.partition(".")[0]
        for finger in plan.hand.fingers.values()
        if finger.command is not None
    }
    return packet in plan.messages or packet not in commands


def open_link(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """Open the devices of a hand on lines of their own.

    Raises:
        ConfigError: its map, or an address, cannot be used.
        DeviceError: a device cannot be opened.

    """
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
    return MappedLinkEndpoint(links, codec)
