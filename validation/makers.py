"""The maps in the box against the packages of the makers and of others, on random and hostile packets.

::

    pip install bota-driver paxini-sdk pymodbus pyrobotiqtactile    # in an environment of its own
    python -m validation.makers --site ENVIRONMENT/lib/python3.11/site-packages
    python -m validation.makers --dexhand CHECKOUT/pyzlg_dexhand --papillarray CHECKOUT/pts_protocol.py

Each prints how many packets both understood and both refused, and how often they differ.
``bota-driver`` is a compiled driver of a port: it reads from a pty, in a process of its own.
"""

import argparse
import contextlib
import importlib.util
import json
import math
import os
import pty
import random
import re
import select
import struct
import subprocess
import sys
import tempfile
import time
import tty
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from vegrip.messages import FingertipState
from vegrip.transport.codec import Frame
from vegrip.transport.hands.link_endpoint import PacketStream
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.map_text import changed_text
from vegrip.transport.maps.products import map_of

PACKETS = 10_000
DIFFERS = 4
PAUSE = 0.002  # [s] between packets to bota-driver
Values = tuple[float, ...]
Read = Callable[[bytes], list[Values]]


class Ours:
    """A map of the box, read by what a node reads it with; its channels count from the first value on."""

    def __init__(self, name: str, settings: Sequence[tuple[list[str], Any]] = ()) -> None:
        text = changed_text(map_of(name).read_text(encoding="utf-8"), list(settings))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "hand.toml"
            path.write_text(
                re.sub("^signal =", "zero_is_measured = true\\nsignal =", text, flags=re.M), encoding="utf-8"
            )
            self.codec = MappedCodec(open_plan(path))
        self.counts: Counter[str] = Counter()
        self.stream = PacketStream(self.codec.plan.database.packets, self.counts)

    def states(self, data: bytes) -> list[FingertipState]:
        """Return the states that ``data`` completes in a stream."""
        return [state for frame in self.stream.feed(data, 1) for state in self.codec.decode_all(frame)]


def crc_x25(data: bytes) -> int:
    """Return the CRC-16/X-25, bit by bit."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
    return value ^ 0xFFFF


def harmed(packet: bytes, rng: random.Random) -> bytes:
    """Return ``packet``, one time in three with a bit or a byte changed."""
    if rng.random() > 1 / 3:
        return packet
    place = rng.randrange(len(packet))
    byte = packet[place] ^ (1 << rng.randrange(8)) if rng.random() < 0.5 else rng.randrange(256)
    return packet[:place] + bytes([byte]) + packet[place + 1 :]


def compared(name: str, packets: Sequence[bytes], ours: Read, theirs: Read) -> bool:
    """Print how often ``ours`` and ``theirs`` agree on ``packets``; return whether always."""
    found: Counter[str] = Counter()
    for packet in packets:
        one, other = ours(packet), theirs(packet)
        same = len(one) == len(other) and all(map(_is_close, one, other))
        found["differ" if not same else "understood" if one else "refused"] += 1
        if not same and found["differ"] <= 3:
            print(f"  {packet.hex()}: {one} against {other}")
    print(f"{name}: {found['understood']} understood, {found['refused']} refused, {found['differ']} differ")
    return not found["differ"]


def _is_close(one: Values, other: Values) -> bool:
    return len(one) == len(other) and all(
        math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-15) or (math.isnan(a) and math.isnan(b))
        for a, b in zip(one, other, strict=True)
    )


def paxini() -> bool:
    """The resultant force of a PX-6AX, asked for at its converter board."""
    from paxini_sdk import protocol  # type: ignore[import-not-found]  # noqa: PLC0415
    from paxini_sdk.exceptions import PaxiniError  # type: ignore[import-not-found]  # noqa: PLC0415

    rng = random.Random(1)
    mine = Ours("paxini-px6ax")
    device = mine.codec.plan.hand.device
    asked = protocol.build_fin_request(protocol.FIN_FUNC_FORCE, 0x3F0, read=True, data_len=3)
    zero = protocol.build_fin_request(protocol.FIN_FUNC_CALIBRATION, 3, read=False, data=b"\x01")
    if [bytes.fromhex(each["data"]) for each in (*device.poll, *device.zero)] != [asked, zero]:
        print("paxini-px6ax: what the map asks is not what the package asks")
        return False

    def answer() -> bytes:
        head = b"\xaa\x55\x0d\x00\x01\x00\xfb\xf0\x03\x00\x00\x03\x00"
        body = head + bytes([rng.choice((0, 0, 1, rng.randrange(12)))]) + rng.randbytes(3)
        return harmed(body + bytes([-sum(body) & 0xFF]), rng)

    def theirs(packet: bytes) -> list[Values]:
        try:
            told = protocol.parse_fin_response(packet)
        except PaxiniError:
            return []
        is_ours = (told.device_id, told.func_code, told.addr, told.data_len) == (1, 0xFB, 0x3F0, 3)
        if told.status not in (0, 1) or not is_ours or told.reserved:
            return []
        x, y, z = protocol.split_force_xyz(told.data)
        return [(0.1 * x, 0.1 * y, 0.1 * z)]

    def ours(packet: bytes) -> list[Values]:
        mine.stream.reset()
        return [_forces(state) for state in mine.states(packet)]

    return compared("paxini-px6ax", [answer() for _ in range(PACKETS)], ours, theirs)


def _forces(state: FingertipState) -> Values:
    return state.tangential_force_x, state.tangential_force_y, state.normal_force


def robotiq() -> bool:
    """Packets of a TSF-85: fields in any order, some of them cut or unknown."""
    from pyrobotiqtactile.protocol import PacketParser  # type: ignore[import-not-found]  # noqa: PLC0415

    rng = random.Random(2)
    mine = Ours("robotiq-tsf85", [(["fingers", "*", "taxels", "scale"], 1.0)])
    sizes = {0x10: 56, 0x20: 2, 0x30: 6, 0x40: 6, 0x50: 6, 0x60: 2, 0x70: 8}

    def packet() -> bytes:
        body = b""
        while rng.random() < 0.8 and len(body) < 150:
            kind = rng.choice((0x10, 0x10, *sizes))
            body += bytes([kind | rng.randrange(2) << 2]) + rng.randbytes(sizes[kind])
        return b"\x9a\x00\x61" + bytes([len(body)]) + body

    def theirs(data: bytes) -> list[Values]:
        parser = PacketParser()
        found: list[Values] = []
        original = parser.fingers
        for one in parser.feed(data):
            for place, finger in enumerate(original):
                finger.static_tactile = _Told(found, place)
            parser.parse_sensor_packet(one)
            found += [
                (place, sum(f.static_tactile))
                for place, f in enumerate(original)
                if type(f.static_tactile) is list
            ]
        return sorted(found)

    def ours(data: bytes) -> list[Values]:
        mine.stream.reset()
        last = {("first", "second").index(state.finger): state.normal_force for state in mine.states(data)}
        return sorted((float(place), force) for place, force in last.items())

    sound = compared("robotiq-tsf85", [packet() for _ in range(PACKETS)], ours, theirs)
    whole = b"".join(packet() for _ in range(500))
    cut, sums = PacketParser(), []
    for one in cut.feed(whole):
        sums += [value for _, value in theirs(one)]
    mine.stream.reset()
    mixed: list[float] = []
    while whole:
        size = rng.randrange(1, 60)
        for frame in mine.stream.feed(whole[:size], 1):
            mixed += [state.normal_force for state in mine.codec.decode_all(frame)]
        whole = whole[size:]
    missing = set(sums) - set(mixed)
    print(f"robotiq-tsf85, in pieces: {len(mixed)} states, {len(missing)} of theirs missing")
    return sound and not missing


class _Told(tuple):  # type: ignore[type-arg]
    """Stands where their parser writes; what is still there was not written."""

    def __new__(cls, *_: object) -> "_Told":
        return super().__new__(cls)


def dexhand(package: Path) -> bool:
    """Feedback frames of a DexHand021, by the maker's own decoder."""
    sys.path.insert(0, str(package.parent))
    for name in ("pyzlg_dexhand", "pyzlg_dexhand.dexhand_protocol"):  # its front door loads a driver library
        spec = importlib.util.spec_from_loader(name, loader=None, is_package=True)
        assert spec is not None  # noqa: S101
        module = importlib.util.module_from_spec(spec)
        module.__path__ = [str(package.parent / name.replace(".", "/"))]
        sys.modules[name] = module
    protocol = sys.modules["pyzlg_dexhand.dexhand_protocol"]
    source = package / "dexhand_protocol" / "__init__.py"
    exec(compile(source.read_text(encoding="utf-8"), str(source), "exec"), protocol.__dict__)  # noqa: S102
    messages: Any = importlib.import_module("pyzlg_dexhand.dexhand_protocol.messages")
    rng = random.Random(3)
    mine = Ours("dexhand021")

    def theirs(data: bytes) -> list[Values]:
        try:
            told = messages.process_message(0x181, data).feedback.tactile
        except ValueError:
            return []
        if told is None:
            return []
        angle = math.radians(told.direction)
        force = told.tangential_force
        return [
            (told.normal_force, force * math.cos(angle), force * math.sin(angle), float(told.temperature))
        ]

    def ours(data: bytes) -> list[Values]:
        return [
            (state.normal_force, state.tangential_force_x, state.tangential_force_y, state.temperature)
            for state in mine.codec.decode_all(Frame(0x181, data, True, 1))
        ]

    def frame() -> bytes:
        data = bytearray(rng.randbytes(rng.choice((46, 48, 48, 48, 42, 41, 20, 8))))
        if len(data) >= 42:
            struct.pack_into("<f4xf4xH", data, 16, rng.gauss(0, 5), rng.gauss(0, 5), rng.randrange(360))
        return bytes(data)

    return compared("dexhand021", [frame() for _ in range(PACKETS)], ours, theirs)


def inspire() -> bool:
    """What an RH56DFTP is asked and answers, by the frames of pymodbus."""
    from pymodbus.exceptions import ModbusException  # noqa: PLC0415
    from pymodbus.framer import FramerSocket  # noqa: PLC0415
    from pymodbus.pdu import DecodePDU, register_message  # noqa: PLC0415

    rng = random.Random(6)
    mine = Ours("inspire-rh56dftp", [(["fingers", "*", "normal_force", "scale"], 1.0)])
    client, server = FramerSocket(DecodePDU(False)), FramerSocket(DecodePDU(True))
    asked = register_message.ReadHoldingRegistersRequest(dev_id=1, transaction_id=1, address=1582, count=6)
    if bytes.fromhex(mine.codec.plan.hand.device.poll[0]["data"]) != server.buildFrame(asked):
        print("inspire-rh56dftp: what the map asks is not what the package asks")
        return False

    def answer() -> bytes:
        words = [rng.randrange(1 << 16) for _ in range(6)]
        pdu = register_message.ReadHoldingRegistersResponse(dev_id=1, transaction_id=1, registers=words)
        return harmed(bytes(client.buildFrame(pdu)), rng)

    def theirs(packet: bytes) -> list[Values]:
        size, unit, transaction, data = client.decode(packet)
        if (size, unit, transaction) != (len(packet), 1, 1):
            return []
        try:
            told = client.decoder.decode(data)
        except ModbusException:
            return []
        words = getattr(told, "registers", [])
        if not isinstance(told, register_message.ReadHoldingRegistersResponse) or len(words) != 6:
            return []
        signed = struct.unpack(">6h", struct.pack(">6H", *words))
        return [(float(signed[drive]),) for drive in (4, 3, 2, 1, 0)]  # the thumb is the fifth

    def ours(packet: bytes) -> list[Values]:
        mine.stream.reset()
        return [(state.normal_force,) for state in mine.states(packet)]

    return compared("inspire-rh56dftp", [answer() for _ in range(PACKETS)], ours, theirs)


def papillarray(source: Path) -> bool:
    """Packets of a PapillArray of two sensors, with blocks in any order, by a public decoder."""
    spec = importlib.util.spec_from_file_location("pts_protocol", source)
    assert spec is not None  # noqa: S101
    assert spec.loader is not None  # noqa: S101
    theirs_: Any = importlib.util.module_from_spec(spec)
    sys.modules["pts_protocol"] = theirs_
    spec.loader.exec_module(theirs_)
    rng = random.Random(4)
    mine = Ours("contactile-papillarray")

    def floats(count: int) -> bytes:
        return struct.pack(f"<{count}f", *(rng.gauss(0, 3) for _ in range(count)))

    def packet() -> bytes:
        pillars = b"".join(
            struct.pack("<H", 9) + bytes(18) + b"".join(b"\2\0" + floats(6) for _ in range(9)) for _ in "12"
        )
        blocks = {
            1: struct.pack("<IQ", rng.randrange(1 << 32), rng.randrange(1 << 50)),
            3: struct.pack("<HHH", 2, 6, 6) + pillars,
            4: struct.pack("<HHH", 2, 6, 32) + b"".join(b"\2\0" + floats(6) for _ in "12"),
            6: struct.pack("<HHH", 2, 6, 17) + b"".join(b"\1\0\2" + floats(2) for _ in "12"),
            7: rng.randbytes(5),
        }
        order = list(blocks)
        rng.shuffle(order)
        table, body, at = b"", b"", 1 + 4 * len(order)
        for kind in order:
            table += struct.pack("<HH", kind, at + len(body))
            body += blocks[kind]
        data = b"\2" + table + body
        data += struct.pack("<H", sum(data) & 0xFFFF)
        return harmed(b"\x55\x66\x77\x88" + data + b"\xaa\xbb\xcc\xdd", rng)

    def theirs(whole: bytes) -> list[Values]:
        data = whole[4:-4]
        marks = whole[:4] == b"\x55\x66\x77\x88", whole[-4:] == b"\xaa\xbb\xcc\xdd"
        if not all(marks) or not theirs_.verify_checksum(data) or data[0] != 2:
            return []
        try:
            parsed = theirs_.parse_packet(data)
        except (ValueError, IndexError, struct.error):
            return []
        return [
            (*map(float, force), 1e-3 * float(torque[2]))
            for force, torque in zip(parsed.global_forces, parsed.global_torques, strict=True)
        ]

    def ours(whole: bytes) -> list[Values]:
        mine.stream.reset()
        return [(*_forces(state), state.torque_z) for state in mine.states(whole)]

    return compared("contactile-papillarray", [packet() for _ in range(PACKETS)], ours, theirs)


BOTA = """
import json, sys
import bota_driver as b
config = b.BotaDriverConfig()
config.communication_interface_name = "Bota_Binary_gen0"
serial = b.BotaBinaryCommunicationInterfaceConfig()
serial.com_port, serial.baudrate = sys.argv[1], 460800
config.binary_communication_interface_params = serial
sensor = b.Gen0SensorOperationConfig()
sensor.sinc_length = 512
sensor.wrench_offset = b.WrenchOffset()
for name in ("fx", "fy", "fz", "tx", "ty", "tz"):
    setattr(sensor.wrench_offset, name, 0.0)
config.gen0_sensor_operation_params = sensor
config.product_name, config.serial_number = "BFT-SENS-SER-M8", "SN1"
config.driver_operation_params.skip_metadata_reading = True
config.driver_operation_params.runtime_verbosity = False
driver = b.BotaDriver(config)
driver.configure() and driver.activate()
while True:
    try:
        frame = driver.read_frame_blocking()
    except RuntimeError:
        break
    row = [frame.timestamp, *frame.force, *frame.torque, frame.temperature, frame.status.val]
    print("FRAME", json.dumps(row), flush=True)
"""


def bota(site: str, seconds: float) -> bool:
    """A SensONE on a pty: each frame that the maker's driver believes is one of ours, and the same."""
    rng = random.Random(5)
    mine = Ours("bota-sensone")
    device, port = pty.openpty()
    tty.setraw(device)
    tty.setraw(port)
    os.set_blocking(device, False)  # what the driver does not read is lost
    environment = {**os.environ, "PYTHONPATH": site}
    said = tempfile.TemporaryFile("w+")  # noqa: SIM115 (a pipe that is not read meanwhile would stop the driver)
    driver = subprocess.Popen(
        [sys.executable, "-c", BOTA, os.ttyname(port)], stdout=said, text=True, env=environment
    )
    ours: dict[int, Values] = {}
    line, streams, sent, begun = b"", False, 0, time.monotonic()
    asked: list[str] = []
    while time.monotonic() - begun < seconds and driver.poll() is None:
        if select.select([device], [], [], PAUSE)[0]:
            line += os.read(device, 256)
            *lines, line = line.split(b"\n")
            for one in lines:
                asked.append(one.decode("latin-1"))
                streams = one[:1] == b"R" or (streams and one[:1] != b"C")
                os.write(device, b"r,0," + one[:1] + b",0\r\n")
        if not streams:
            continue
        sent += 1
        status = rng.choice((0, 0, 0, 0, 1))
        values = [rng.gauss(0, 20) for _ in range(6)]
        body = struct.pack("<H6fIf", status, *values, 10_000 * sent, rng.uniform(10, 60))
        packet = b"\xaa" + body + struct.pack("<H", crc_x25(body))
        if sent > 300:  # a driver that starts on damage gives up
            packet = harmed(packet, rng)
        for state in mine.states(packet):
            stamp = mine.codec.plan.database.packets[0].clock
            assert stamp is not None  # noqa: S101
            ours[stamp[0](packet, 0)] = (*_forces(state), state.torque_z)
        with contextlib.suppress(BlockingIOError):
            os.write(device, packet)
    driver.kill()
    driver.wait()
    said.seek(0)
    printed = said.read()
    theirs = [json.loads(each) for each in re.findall(r"^FRAME (\[[^\[\]]*\])$", printed, flags=re.M)]
    wrong = 0
    for stamp_, fx, fy, fz, _mx, _my, mz, _temperature, _status in theirs:
        wrong += stamp_ not in ours or not _is_close(ours[stamp_], (fx, fy, -fz, mz))
    wanted = [each["text"].strip() for each in mine.codec.plan.hand.device.opening]
    unasked = set(wanted) - set(asked)
    print(
        f"bota-sensone: {sent} packets sent, {len(ours)} understood here, {len(theirs)} by the "
        f"driver, {wrong} differ; "
        f"commands of the map that the driver does not send: {sorted(unasked) or 'none'}"
    )
    return bool(theirs) and not wrong and not unasked


def main() -> int:
    """Compare what is asked for; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--site", default="", help="site-packages with the packages above")
    parser.add_argument(
        "--dexhand", type=Path, help="folder pyzlg_dexhand of a checkout of DexRobot/pyzlg_dexhand"
    )
    parser.add_argument("--papillarray", type=Path, help="pts_protocol.py of langxin11/contactile_pts_lab")
    parser.add_argument(
        "--seconds", type=float, default=60.0, help="for bota-driver, at some 400 packets a second"
    )
    given = parser.parse_args()
    sys.path.append(given.site)
    found: list[bool] = []
    if given.site:
        found += [paxini(), robotiq(), inspire(), bota(given.site, given.seconds)]
    if given.dexhand is not None:
        found.append(dexhand(given.dexhand))
    if given.papillarray is not None:
        found.append(papillarray(given.papillarray))
    return 0 if all(found) else DIFFERS


if __name__ == "__main__":
    sys.exit(main())
