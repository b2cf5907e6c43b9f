"""Devices of the maps in the box, packed by struct from their documents, on a pty, UDP, TCP or a CAN bus."""

import os
import pty
import select
import socket
import struct
import tty

import can

NORMAL, X, Y, TORQUE = 2.0, 0.5, -0.25, 0.012  # [N], [N m] of every device


def crc_x25(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
    return value ^ 0xFFFF


class Pty:
    """A serial line; the address is a link, so that the device can be plugged in again."""

    kind = "serial"

    def __init__(self, folder):
        self.address = str(folder / "tty")
        self.plug()

    def plug(self):
        self.end, self._port = pty.openpty()
        tty.setraw(self.end)
        tty.setraw(self._port)
        os.set_blocking(self.end, False)
        if os.path.lexists(self.address):
            os.unlink(self.address)
        os.symlink(os.ttyname(self._port), self.address)

    def read(self):
        try:
            return os.read(self.end, 4096)
        except (BlockingIOError, OSError):
            return b""

    def write(self, data):
        os.write(self.end, data)

    def cut(self):
        os.close(self._port)
        os.close(self.end)
        self.end = -1

    def close(self):
        if self.end >= 0:
            self.cut()


class Udp:
    kind = "udp"

    def __init__(self, folder):
        self._port = 0
        self.plug()

    def plug(self):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", self._port))
        self._socket.setblocking(False)
        self._port = self._socket.getsockname()[1]
        self.address, self._peer = f"127.0.0.1:{self._port}", None

    def read(self):
        try:
            data, self._peer = self._socket.recvfrom(4096)
        except BlockingIOError:
            return b""
        return data

    def write(self, data):
        if self._peer is not None:
            self._socket.sendto(data, self._peer)

    def cut(self):
        self._socket.close()

    close = cut


class Tcp:
    kind = "tcp"

    def __init__(self, folder):
        self._port = 0
        self.plug()

    def plug(self):
        self._listening = socket.socket()
        self._listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._listening.bind(("127.0.0.1", self._port))
        self._listening.listen(1)
        self._listening.setblocking(False)
        self._port = self._listening.getsockname()[1]
        self.address, self._peer = f"127.0.0.1:{self._port}", None

    def read(self):
        try:
            if self._peer is None or select.select([self._listening], [], [], 0.0)[0]:
                peer, _ = self._listening.accept()
                if self._peer is not None:
                    self._peer.close()
                self._peer = peer
                self._peer.setblocking(False)
            return self._peer.recv(4096)
        except (BlockingIOError, ConnectionError):
            return b""

    def write(self, data):
        if self._peer is not None:
            self._peer.send(data)

    def cut(self):
        if self._peer is not None:
            self._peer.close()
        self._listening.close()

    close = cut


class Device:
    """Answers, and once it was told to, sends a packet each step."""

    carrier, settings, streams = Pty, (), False
    is_protected = True  # what is cut is not completed by the next answer

    def __init__(self, folder):
        self.port, self.count, self.zeros, self.heard = self.carrier(folder), 0, 0, []

    def step(self, harm=lambda packet: packet):
        request = self.port.read()
        if request:
            self.heard.append(request)
            self.hear(request, harm)
        if self.streams:
            self.count += 1
            self.port.write(harm(self.packet()))

    def reset(self):
        self.streams = False

    def hear(self, request, harm):
        raise NotImplementedError

    def packet(self):
        raise NotImplementedError


class Bota(Device):
    """Answers each line, and sends after R."""

    name = "bota-sensone"

    def hear(self, request, harm):
        for line in request.split():
            self.port.write(b"r,0," + line[:1] + b",0\r\n")
            self.streams = line[:1] == b"R"

    def packet(self):
        body = struct.pack("<H6fIf", 0, X, Y, -NORMAL, 0.0, 0.0, TORQUE, 10_000 * self.count, 25.0)
        return b"\xaa" + body + struct.pack("<H", crc_x25(body))


class Ati(Device):
    """Sends records after command 2; 0x42 is zero."""

    name, carrier, force, torque = "ati-net-ft", Udp, 1_000_000, 1_000_000
    settings = (
        (["fingers", "*", "normal_force", "scale"], -1e-6),
        *(
            (["fingers", "*", name, "scale"], 1e-6)
            for name in ("tangential_force_x", "tangential_force_y", "torque_z")
        ),
    )

    def hear(self, request, harm):
        head, command, _ = struct.unpack(">HHI", request)
        assert head == 0x1234
        self.zeros += command == 0x42
        self.streams = command == 2 or (self.streams and command != 0)

    def packet(self):
        values = [round(value * self.force) for value in (X, Y, -NORMAL)]
        return struct.pack(
            ">III6i", self.count, 7 * self.count, 0, *values, 0, 0, round(TORQUE * self.torque)
        )


class Hex(Ati):
    name, force, torque, settings = "onrobot-hex", 10_000, 100_000, ()


class Paxini(Device):
    """Answers each question for the resultant force."""

    name = "paxini-px6ax"

    def hear(self, request, harm):
        assert sum(request) & 0xFF == 0
        body = b"\xaa\x55\x0d\x00" + request[4:13] + b"\x01"
        if request[6] == 0x79:
            self.zeros += 1
        else:
            body += struct.pack("bbB", round(10 * X), round(10 * Y), round(10 * NORMAL))
        self.port.write(harm(body + bytes([-sum(body) & 0xFF])))


class Robotiq(Device):
    """Sends both fingers by itself after command 0x58."""

    name, is_protected = "robotiq-tsf85", False
    settings = ((["fingers", "*", "taxels", "scale"], NORMAL / 280),)

    def hear(self, request, harm):
        self.streams = request[2] == 0x58 and request[4] > 0

    def packet(self):
        pressures = struct.pack(">28H", *[10] * 28)
        body = b"\x10" + pressures + b"\x70" + bytes(8) + b"\x14" + pressures
        return b"\x9a\x00\x61" + bytes([len(body)]) + body


class Papillarray(Device):
    """Two sensors on a hub, a table of offsets in front."""

    name, friction = "contactile-papillarray", -1.0

    def hear(self, request, harm):
        self.zeros += b"z\n" in request
        self.streams = b"S\n" in request or (self.streams and b"s\n" not in request)

    def packet(self):
        one = b"\2\0" + struct.pack("<6f", X, Y, NORMAL, 0, 0, 1e3 * TORQUE)
        blocks = {
            1: struct.pack("<IQ", self.count, 1000 * self.count),
            4: struct.pack("<HHH", 2, 6, 32) + 2 * one,
            6: struct.pack("<HHH", 2, 6, 17) + 2 * (b"\1\0\2" + struct.pack("<2f", self.friction, 3.5)),
        }
        table, body, begin = b"", b"", 1 + 4 * len(blocks)
        for kind, block in blocks.items():
            table += struct.pack("<HH", kind, begin + len(body))
            body += block
        data = b"\2" + table + body
        return b"\x55\x66\x77\x88" + data + struct.pack("<H", sum(data) & 0xFFFF) + b"\xaa\xbb\xcc\xdd"


class Tesollo(Device):
    """Answers each question; twenty motors and five tips of six axes."""

    name, carrier = "tesollo-dg5f", Tcp

    def hear(self, request, harm):
        while request:
            length, command = struct.unpack_from(">HB", request)
            self.zeros += command == 0x0B
            if command == 1:
                motors = b"".join(struct.pack(">Bhhhb", number, 0, 0, 250, 0) for number in range(1, 21))
                tips = (
                    struct.pack(">6h", *(round(10 * v) for v in (X, Y, NORMAL)), 0, 0, round(1e3 * TORQUE))
                    * 5
                )
                self.port.write(harm(struct.pack(">HB", 223, 1) + motors + tips))
            request = request[length:]


class Inspire(Device):
    """Answers Modbus requests for six registers, and those that write five."""

    name, carrier, is_protected = "inspire-rh56dftp", Tcp, False
    settings = (
        (["fingers", "*", "normal_force", "scale"], 0.01),
        (["fingers", "*", "command", "gain"], "100 /N"),
    )

    def hear(self, request, harm):
        while request:
            transaction, protocol, size, unit, function, first, count = struct.unpack_from(
                ">HHHBBHH", request
            )
            assert (protocol, unit) == (0, 1)
            if function == 3:
                assert (first, count, size) == (1582, 6, 6)
                body = struct.pack(">BBB6h", 1, 3, 12, *[round(100 * NORMAL)] * 5, -1)
            else:
                assert (function, first, count, size) == (16, 1498, 5, 17)
                self.heard.append(struct.unpack_from(">5h", request, 13))
                body = struct.pack(">BBHH", 1, 16, first, count)
            self.port.write(harm(struct.pack(">HHH", transaction, 0, len(body)) + body))
            request = request[6 + size :]


class CanDevice:
    """On a bus of its own; ``frames`` answers or sends."""

    settings, streams = (), False

    def __init__(self, channel):
        self.bus = can.Bus(interface="virtual", channel=channel)
        self.heard = []

    def step(self):
        while (message := self.bus.recv(0.0)) is not None:
            self.heard.append((message.arbitration_id, bytes(message.data)))
            self.hear(*self.heard[-1])
        if self.streams:
            self.send_all()

    def send(self, identifier, data):
        self.bus.send(
            can.Message(
                arbitration_id=identifier, data=data, is_extended_id=identifier > 0x7FF, is_fd=len(data) > 8
            )
        )

    def send_all(self):
        """Send a round of what it sends by itself."""


class Dexhand(CanDevice):
    """Sends feedback of a board that was told to, magnitude and direction of the tangential force."""

    name, fingers = "dexhand021", 5

    def hear(self, identifier, data):
        assert data == bytes([3, 0x74, 1, 1, 1])
        self.streams = True

    def send_all(self):
        for board in (1, 3, 4, 5, 6):
            data = struct.pack("<8hfIfIHII", *range(8), NORMAL, 0, abs(X + 1j * Y), 0, 333, 0, 31) + bytes(6)
            self.send(0x180 + board, data)


class Linkerhand(CanDevice):
    """Answers a byte by five bytes behind it."""

    name, fingers = "linkerhand-l20", 5
    settings = (
        (["fingers", "*", "normal_force", "scale"], 0.02),
        (["fingers", "*", "tangential_magnitude", "scale"], 0.01),
        (["fingers", "*", "tangential_direction", "gain"], "3 deg"),
    )

    def hear(self, identifier, data):
        value = {0x20: NORMAL / 0.02, 0x21: abs(X + 1j * Y) / 0.01, 0x22: 333 / 3}[data[0]]
        self.send(0x28, data + bytes([round(value)] * 5))


class Omnihand(CanDevice):
    """Answers under the identifier that asks."""

    name, fingers = "omnihand-2025", 5
    settings = ((["fingers", "*", "taxels", "scale"], 0.1),)

    def hear(self, identifier, data):
        assert len(data) == 64
        assert identifier & 0xFFFFFF == 0x050101
        self.send(identifier, bytes([1, 2, *[1] * 13, 4]).ljust(64, b"\0"))


class Xela(CanDevice):
    """Sends sixteen frames a round; the third axis rests at a count of its own."""

    name, fingers = "xela-uskin", 1
    settings = (
        (["fingers", "*", "normal_force", "zero"], 16 * 30_000.0),
        (["fingers", "*", "normal_force", "gain"], "0.001 N"),
        (["fingers", "*", "tangential_force_x", "gain"], "0.001 N"),
        (["fingers", "*", "tangential_force_y", "gain"], "0.001 N"),
        (["fingers", "*", "tangential_force_x", "zero"], 16 * 20_000.0),
        (["fingers", "*", "tangential_force_y", "zero"], 16 * 20_000.0),
    )

    def hear(self, identifier, data):
        assert (identifier, data) == (0x201, b"\7\0")
        self.streams = True

    def send_all(self):
        for taxel in range(16):
            counts = (20_000 + 1000 * X / 16, 20_000 + 1000 * Y / 16, 30_000 + 1000 * NORMAL / 16)
            self.send(0x710 + taxel, struct.pack(">BHHH", 0, *(round(count) for count in counts)))


DEVICES = (Bota, Ati, Hex, Paxini, Robotiq, Papillarray, Tesollo, Inspire)
CAN_DEVICES = (Dexhand, Linkerhand, Omnihand, Xela)
