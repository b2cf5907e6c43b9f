"""A device at the end of a serial line, a TCP connection or UDP: bytes out and in, without waiting.

A serial line is opened by ``termios`` of the standard library: it has every rate up to 4 Mbit/s that Linux
has, its file can be waited for together with sockets, and pyserial would add nothing but other systems.
"""

import contextlib
import errno
import fcntl
import os
import select
import socket
import stat
import struct
import termios
import tty
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from textwrap import shorten
from typing import Final

from vegrip.clock import NS
from vegrip.errors import ConfigError, DeviceError
from vegrip.transport.sender_clock import SenderClock, StampMap

CHUNK: Final = 4096  # [bytes] read at once
CONNECT_WAIT: Final = 2.0  # [s] for the first connection; later ones are made while the loop goes on
BUSY: Final = (errno.EBUSY, errno.EAGAIN)
MOST_OF_LINE: Final = 60  # characters of the command of another program
LINK_KINDS: Final = ("udp", "tcp", "serial")


SO_TIMESTAMPING: Final = 37  # linux/socket.h, and the type of what comes of it
STAMPS_WANTED: Final = 1 << 2 | 1 << 3 | 1 << 4 | 1 << 6
"""Received by hardware and software, reported of software and of the interface's own clock (net_tstamp.h)."""
STAMPS: Final = struct.Struct("@6l")  # three times in seconds and nanoseconds: kernel, unused, interface
STAMP_ROOM: Final = socket.CMSG_SPACE(STAMPS.size)
Ancillary = Sequence[tuple[int, int, bytes]]
"""Level, type and data of what the kernel adds to a message."""


def stamps_of(ancillary: Ancillary) -> tuple[int, int]:
    """Return the stamps of the kernel, since 1970, and of the interface, on its own clock [ns]; 0: none."""
    for level, kind, data in ancillary:
        if (level, kind) == (socket.SOL_SOCKET, SO_TIMESTAMPING) and len(data) >= STAMPS.size:
            seconds, part, _, _, own_seconds, own_part = STAMPS.unpack_from(data)
            return seconds * NS + part, own_seconds * NS + own_part
    return 0, 0


class Link(ABC):
    """An open way to a device. Whatever goes wrong is an ``OSError``: the way is lost, and is opened anew."""

    is_datagram = False
    is_connection = False  # which is made anew when the device falls silent
    arrived = 0  # [ns] when the last chunk reached this machine, on the monotonic clock; 0: not known
    clock: SenderClock | None = None  # of the network interface, where it stamps

    @abstractmethod
    def fileno(self) -> int:
        """Return the descriptor to wait for."""

    @abstractmethod
    def read(self) -> bytes:
        """Return what has come, b"" when nothing has."""

    @abstractmethod
    def close(self) -> None:
        """Give it back."""

    @abstractmethod
    def _send(self, data: bytes) -> int:
        """Send ``data`` now; return how many bytes of it there was room for."""

    def is_ready(self) -> bool:
        return True

    def write(self, data: bytes) -> None:
        if self._send(data) < len(data):
            raise OSError(errno.ENOBUFS, "no room for a whole command")


Open = Callable[[bool], Link]
"""Opens a link; when asked to wait, a connection is made before it returns."""


class _SocketLink(Link):
    """UDP or TCP to one address."""

    def __init__(self, opened: socket.socket) -> None:
        self._socket = opened
        self.is_datagram = opened.type == socket.SOCK_DGRAM
        self.is_connection = not self.is_datagram
        self._stamps = StampMap()
        if self.is_datagram:  # what came in a stream at one time was not sent at one time
            with contextlib.suppress(OSError):
                opened.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPING, STAMPS_WANTED)

    def fileno(self) -> int:
        return self._socket.fileno()

    def is_ready(self) -> bool:
        try:
            self._socket.getpeername()
        except OSError:
            failure = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
            if failure and self.is_connection:
                raise OSError(failure, os.strerror(failure)) from None
            return self.is_datagram
        return True

    def read(self) -> bytes:
        try:
            data, ancillary, _, _ = self._socket.recvmsg(65536 if self.is_datagram else CHUNK, STAMP_ROOM)
        except BlockingIOError:
            return b""
        self.arrived = self._arrival(ancillary)
        if not data and not self.is_datagram:
            raise ConnectionResetError(errno.ECONNRESET, "closed by the device")
        return data

    def _arrival(self, ancillary: Ancillary) -> int:
        """Return when the kernel, or the interface itself, received what was read; 0: it does not say.

        The clock of the interface is laid on ours by the quickest of its stamps: see :attr:`clock`.
        """
        kernel, hardware = stamps_of(ancillary)
        if not kernel:
            return 0
        arrival = self._stamps.to_monotonic(kernel / NS)
        if not hardware:
            return arrival
        self.clock = self.clock or SenderClock()
        return self.clock.observe(hardware, arrival)

    def _send(self, data: bytes) -> int:
        return self._socket.send(data)

    def close(self) -> None:
        self._socket.close()


class _SerialLink(Link):
    """A tty in raw mode, 8 bits, no parity, no flow control, closed to other programs."""

    def __init__(self, path: str, speed: int) -> None:
        self._file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            fcntl.ioctl(self._file, termios.TIOCEXCL)
            tty.setraw(self._file, termios.TCSANOW)
            settings = termios.tcgetattr(self._file)
            settings[2] = settings[2] & ~(termios.CSTOPB | termios.CRTSCTS) | termios.CLOCAL | termios.CREAD
            settings[4] = settings[5] = speed
            termios.tcsetattr(self._file, termios.TCSANOW, settings)
            termios.tcflush(self._file, termios.TCIOFLUSH)
        except (OSError, termios.error) as error:
            os.close(self._file)
            raise error if isinstance(error, OSError) else OSError(*error.args) from None

    def fileno(self) -> int:
        return self._file

    def read(self) -> bytes:
        try:
            data = os.read(self._file, CHUNK)
        except BlockingIOError:
            return b""
        if not data:
            raise OSError(errno.EIO, "unplugged")
        return data

    def _send(self, data: bytes) -> int:
        return os.write(self._file, data)

    def close(self) -> None:
        if self._file >= 0:
            with contextlib.suppress(OSError):
                fcntl.ioctl(self._file, termios.TIOCNXCL)
            os.close(self._file)
            self._file = -1


def host_and_port(kind: str, address: str, where: str) -> tuple[str, int]:
    """Read the address of a socket of a ``kind``."""
    host, colon, port = address.rpartition(":")
    if not (colon and host and port.isdecimal() and 0 < int(port) < 65536):
        raise ConfigError(f"{where}: 'address' is {address!r}; it must be HOST:PORT, as {EXAMPLES[kind]}")
    return host.strip("[]"), int(port)


def opener(kind: str, address: str, baud: int, local_port: int, where: str) -> Open:
    """Return what opens the device at ``address``: ``HOST:PORT``, or the path of a tty."""
    if not address:
        raise ConfigError(f"{where}: state where the device is: address = {EXAMPLES[kind]}")
    if kind == "serial":
        speed = getattr(termios, f"B{baud}", None)
        if speed is None:
            raise ConfigError(
                f"{where}: 'baud' is {baud}; this system has no such rate, the nearest usual one is 115200"
            )
        return lambda wait: _SerialLink(address, speed)  # noqa: ARG005 (a tty is there or not)
    host, port = host_and_port(kind, address, where)
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except OSError as error:
        raise DeviceError(
            f"{where}: {host!r} cannot be found ({error.strerror or error}); give its number, as 192.168.1.1"
        ) from None
    family, target = found[0], found[4]
    return lambda wait: _connected(kind, family, target, local_port, is_waiting=wait)


EXAMPLES: Final = {"udp": '"192.168.1.1:49152"', "tcp": '"192.168.1.1:502"', "serial": '"/dev/ttyUSB0"'}


def _connected(kind: str, family: int, target: object, local_port: int, *, is_waiting: bool) -> Link:
    opened = socket.socket(family, socket.SOCK_DGRAM if kind == "udp" else socket.SOCK_STREAM)
    try:
        if local_port:
            opened.bind(("", local_port))
        if kind == "tcp":
            opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        opened.setblocking(False)
        failure = opened.connect_ex(target)  # type: ignore[arg-type]
        if failure == errno.EINPROGRESS:
            failure = 0
            if is_waiting:
                is_made = select.select([], [opened], [], CONNECT_WAIT)[1]
                failure = (
                    opened.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) if is_made else errno.ETIMEDOUT
                )
        if failure:
            raise OSError(failure, os.strerror(failure))
    except OSError:
        opened.close()
        raise
    return _SocketLink(opened)


def remedy(kind: str, address: str, error: OSError) -> str:
    """Return one sentence that says what is wrong with a device that cannot be opened, and what to do."""
    causes = {
        errno.ENOTTY: "it is no serial line",
        errno.EISDIR: "it is a folder",
        errno.ECONNREFUSED: "nothing listens there; is the device on, in this mode, and the port right?",
        errno.ETIMEDOUT: f"no answer within {CONNECT_WAIT:g} s; is it on and reachable (`ping`)?",
        errno.EHOSTUNREACH: "this computer has no address in the network of the device",
        errno.ENETUNREACH: "this computer has no address in the network of the device",
        errno.EADDRINUSE: "another program has the local port; end it, or state another local_port",
    }
    if kind == "serial":
        programs = ", ".join(holders(address)) if error.errno in BUSY else ""
        who = f"{programs}; end it first" if programs else f"`sudo fuser -v {address}` names it"
        causes |= dict.fromkeys(BUSY, f"another program has it: {who}") | {
            errno.ENOENT: "there is no such file; see `ls /dev/serial/by-id`, and plug it in",
            errno.EACCES: f"you may not; `sudo usermod -aG {_group(address)} $USER`, then log in again",
        }
    cause = causes.get(error.errno or 0) or error.strerror or error
    return f"the device at {address} cannot be opened: {cause}"


def holders(path: str) -> list[str]:
    """Return which programs have the file open, of those that this user may look at."""
    wanted, found = os.path.realpath(path), []
    for process in sorted(Path("/proc").glob("[0-9]*")):
        with contextlib.suppress(OSError):  # it has ended, or is of another user
            if any(str(each.readlink()) == wanted for each in (process / "fd").iterdir()):
                line = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                found.append(f"{shorten(line, MOST_OF_LINE)} (process {process.name})")
    return found


def _group(path: str) -> str:
    import grp  # noqa: PLC0415 (only to say who may)

    try:
        about = Path(path).stat()
        return grp.getgrgid(about.st_gid).gr_name if about.st_mode & stat.S_IWGRP else "dialout"
    except (OSError, KeyError):
        return "dialout"
