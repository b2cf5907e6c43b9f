"""The other end of a map: a virtual device on a pty, a port of loopback or a CAN bus.

States are sent into it as a virtual hand feels them, and leave as the device's own packets, at its own time;
what it is commanded comes out as force commands.
"""

import os
import pty
import socket
import tty
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import can

from vegrip.clock import NS, WallClock
from vegrip.config import build, parameter
from vegrip.errors import ConfigError, DeviceError
from vegrip.messages import FingertipState, ForceCommand, Message, Reason
from vegrip.transport.byte_link import CHUNK
from vegrip.transport.can_port import CanPort, open_port
from vegrip.transport.canbus.frame_time import fd_size
from vegrip.transport.codec import Frame
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.hands.virtual_device import VirtualDevice
from vegrip.transport.hands.virtual_drive import Simulated, VirtualDrive
from vegrip.transport.hands.virtual_dynamixel import Dynamixel
from vegrip.transport.hands.virtual_robotiq import RobotiqRtu, RobotiqUrcap
from vegrip.transport.hands.virtual_wsg import Wsg
from vegrip.transport.mapped.plan import Plan, open_plan
from vegrip.transport.open import CanSettings, Hand, open_bus

LIFETIME_PERIODS: Final = 10  # of repeated commands, after which silence counts as the end of them
DRIVES: Final[dict[str, type[VirtualDrive]]] = {
    "robotiq": RobotiqRtu,
    "robotiq-urcap": RobotiqUrcap,
    "wsg": Wsg,
    "dynamixel": Dynamixel,
}
"""Drives that have a simulation of their own, by ``speaks`` of ``[product.virtual]``."""
LOOPBACK: Final = ("127.0.0.1", "localhost")


class DevicePort(ABC):
    """Where a virtual device is spoken to; the other side may come and go."""

    address = ""
    """Where it is found, as ``address`` of the transport says it."""

    @abstractmethod
    def read(self) -> Frame | None:
        """Return what has come, None when nothing has."""

    @abstractmethod
    def write(self, frame: Frame) -> None:
        """Send, or lose it when no one listens."""

    @abstractmethod
    def close(self) -> None:
        """Give it back."""


class PtyPort(DevicePort):
    """A serial line: a pty under a name of its own."""

    def __init__(self, path: str) -> None:
        self._end, self._other = pty.openpty()
        tty.setraw(self._end)
        tty.setraw(self._other)
        os.set_blocking(self._end, False)
        self.address = path
        link = Path(path)
        try:
            if link.is_symlink():
                link.unlink()
            link.symlink_to(os.ttyname(self._other))
        except OSError as error:
            self._shut()
            raise DeviceError(f"{path} cannot be made: {error.strerror}; name a file that is none") from None

    def read(self) -> Frame | None:
        try:
            data = os.read(self._end, CHUNK)
        except OSError:
            return None
        return Frame(-1, data, False, 0) if data else None

    def write(self, frame: Frame) -> None:
        with suppress(OSError):
            os.write(self._end, frame.data)

    def close(self) -> None:
        Path(self.address).unlink(missing_ok=True)
        self._shut()

    def _shut(self) -> None:
        os.close(self._end)
        os.close(self._other)


class SocketPort(DevicePort):
    """A port of loopback, for the one who spoke last."""

    def __init__(self, kind: str, address: str) -> None:
        host, _, port = address.rpartition(":")
        if host not in LOOPBACK or not port.isdecimal():
            raise ConfigError(f"'address' is {address!r}; a virtual device is at 127.0.0.1:PORT, 0 is any")
        self._is_stream = kind == "tcp"
        self._socket = socket.socket(
            socket.AF_INET, socket.SOCK_STREAM if self._is_stream else socket.SOCK_DGRAM
        )
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setblocking(False)
        try:
            self._socket.bind(("127.0.0.1", int(port)))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise DeviceError(f"the port {port} of loopback cannot be taken: {error}; 0 takes any") from None
        if self._is_stream:
            self._socket.listen(1)
        self.address = f"127.0.0.1:{self._socket.getsockname()[1]}"
        self._peer: Any = None  # the connection, or the address of who spoke last

    def read(self) -> Frame | None:
        try:
            if self._is_stream:
                return self._read_stream()
            data, self._peer = self._socket.recvfrom(CHUNK)
        except OSError:
            return None
        return Frame(-1, data, False, 0)

    def _read_stream(self) -> Frame | None:
        with suppress(BlockingIOError):
            peer, _ = self._socket.accept()
            self._drop()
            peer.setblocking(False)
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._peer = peer
        if self._peer is None:
            return None
        data = self._peer.recv(CHUNK)
        if not data:
            self._drop()
            return None
        return Frame(-1, data, False, 0)

    def write(self, frame: Frame) -> None:
        with suppress(OSError):
            if self._peer is not None and self._is_stream:
                self._peer.send(frame.data)
            elif self._peer is not None:
                self._socket.sendto(frame.data, self._peer)

    def close(self) -> None:
        self._drop()
        self._socket.close()

    def _drop(self) -> None:
        if self._is_stream and self._peer is not None:
            self._peer.close()
        self._peer = None


class BusPort(DevicePort):
    """A place on a CAN bus."""

    def __init__(self, settings: CanSettings) -> None:
        self._bus, _, timing = open_bus(settings)
        self.address = settings.channel
        self._port: CanPort = open_port(self._bus, Counter(), timing, extended=True)

    def read(self) -> Frame | None:
        return self._port.receive(0.0)

    def write(self, frame: Frame) -> None:
        with suppress(can.CanError, OSError):
            self._port.send(frame._replace(data=frame.data.ljust(fd_size(len(frame.data)), b"\0")))

    def close(self) -> None:
        self._bus.shutdown()


@dataclass(frozen=True)
class DeviceSettings:
    """``[transport]`` with ``kind = "device"``."""

    kind: str = parameter("device")
    map: str = parameter("", doc="file that describes the device")
    latency: float = parameter(1e-3, unit="s", low=0.0, high=1.0, doc="of its answers and samples")
    address: str = parameter("", doc="of a tty to make, or 127.0.0.1:PORT; a CAN hand has none")
    channel: str = parameter("", doc="of a CAN bus, instead of that of the map")
    interface: str = parameter("vegrip", doc="of a CAN bus")


class VirtualDeviceEndpoint(Endpoint):
    """States of ours in, packets of a device out; its commands as force commands."""

    def __init__(self, device: Simulated, port: DevicePort, lifetime: float) -> None:
        self.address = port.address
        self._device, self._port, self._lifetime = device, port, round(lifetime * NS)
        self._clock = WallClock()
        self._seq = 0

    @property
    def rejected(self) -> Mapping[str, int]:
        return self._device.counts

    def receive(self, timeout: float) -> Sequence[Message]:
        """Do for ``timeout`` [s] what the device does; return what it is commanded."""
        deadline = self._clock.now() + round(timeout * NS)
        messages: list[Message] = []
        while True:
            now = self._clock.now()
            while (frame := self._port.read()) is not None:
                self._device.take_in(frame, now)
                messages += self._commands(now)
            for frame in self._device.due(now):
                self._port.write(frame)
            if messages or now >= deadline:
                break
            self._clock.sleep_until(min(deadline, now + NS // 1000))
        self.arrivals = [now] * len(messages)
        return messages

    def send(self, message: Message) -> None:
        if isinstance(message, FingertipState):
            self._device.sense(message)

    def close(self) -> None:
        self._port.close()

    def _commands(self, now: int) -> list[ForceCommand]:
        found = []
        for finger, force in self._device.taken():
            self._seq += 1
            found.append(ForceCommand(now, finger, self._seq, force, 0.0, Reason.HOLD, now + self._lifetime))
        return found


def open_device(table: Mapping[str, Any], hand: Hand, where: str) -> VirtualDeviceEndpoint:
    """Open the virtual device of a map."""
    settings = build(DeviceSettings, table, where)
    plan = open_plan(settings.map, tuple(name for name in hand.fingers if name) or None)
    device = virtual_device(plan, settings.latency)
    lifetime = LIFETIME_PERIODS * plan.hand.command.period
    return VirtualDeviceEndpoint(device, _port(plan.hand.transport, settings), lifetime)


def virtual_device(plan: Plan, latency: float = 0.0) -> Simulated:
    """Return the simulation of a drive, or else of any device by its map."""
    speaks = plan.hand.product.get("virtual", {}).get("speaks", "")
    return DRIVES[speaks](plan, latency) if speaks in DRIVES else VirtualDevice(plan, latency)


def _port(transport: Mapping[str, Any], settings: DeviceSettings) -> DevicePort:
    kind = transport.get("kind", "can")
    if kind == "serial":
        return PtyPort(settings.address)
    if kind in ("udp", "tcp"):
        return SocketPort(kind, settings.address)
    bus = {**transport, "interface": settings.interface}
    return BusPort(build(CanSettings, bus | ({"channel": settings.channel} if settings.channel else {}), ""))
