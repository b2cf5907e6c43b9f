"""A state out of a mapped message of a foreign hand against one out of our own layout, in the same run.

Both hands send the same six quantities of one finger in one frame with a counter and a checksum: ours as the
CAN FD frame of ``proto/fingertip.dbc``, theirs in a layout with other bits, units and signs and a CRC-16 by
polynomial (``mapped_fd_state``) or, as classic frames are, in two messages of which the second completes the
state (``mapped_classic_state``). The ratio is theirs (our own layout) over ours (mapped): above 1/1.5 is
wanted.
"""

import struct
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks._timing import compared
from vegrip.messages import FingertipState
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.sequence import Sequence as Counted
from vegrip.transport.hands.link_endpoint import PacketStream
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.commands import rounding
from vegrip.transport.mapped.compiled import made, packing
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.checksums import ChecksumMap, make_crc, protection

BATCH = 100
MILLISECOND = 1_000_000
VALUES = {"Fz": 4.0, "Fx": 0.5, "Fy": -0.25, "Tz": 0.002, "Depth": 0.001, "Slip": 0.0}
CHANNELS = {
    "Fz": "normal_force",
    "Fx": "tangential_force_x",
    "Fy": "tangential_force_y",
    "Tz": "torque_z",
    "Depth": "displacement",
    "Slip": "slip",
}
SIGNALS = """ SG_ Fz : 7|16@0- (0.01,0) [0|0] "gf" X
 SG_ Fx : 23|16@0- (0.01,0) [0|0] "gf" X
 SG_ Fy : 39|16@0- (0.01,0) [0|0] "gf" X
"""
MOTION = """ SG_ Tz : {0}|16@0- (0.01,0) [0|0] "Ncm" X
 SG_ Depth : {1}|16@0- (0.001,0) [0|0] "mm" X
 SG_ Slip : {2}|1@0+ (1,0) [0|0] "" X
"""
HEAD = 'VERSION ""\nNS_ :\nBS_:\nBU_: X\n'
CHECK = ' SG_ Cnt : {0}|8@0+ (1,0) [0|0] "" X\n SG_ Crc : {1}|{2}@0+ (1,0) [0|0] "" X\n'
FD = f"{HEAD}BO_ 256 Tip: 16 X\n{SIGNALS}{MOTION.format(55, 71, 87)}{CHECK.format(103, 119, 16)}"
CLASSIC = (
    f"{HEAD}BO_ 256 Load: 8 X\n{SIGNALS}{CHECK.format(55, 63, 8)}"
    f"BO_ 257 Motion: 8 X\n{MOTION.format(7, 23, 39)}{CHECK.format(55, 63, 8)}"
)
CRC16 = {"kind": "crc16", "signal": "Crc", "polynomial": 0x1021, "start": 0xFFFF}
CRC8 = {"kind": "crc8", "signal": "Crc", "polynomial": 0x2F, "start": 0xFF, "final": 0xFF}


def run() -> dict[str, dict[str, float]]:
    results = {}
    for name, database, checksum, fd in (("fd", FD, CRC16, True), ("classic", CLASSIC, CRC8, False)):
        ours, theirs = mapped(database, checksum), own(fd)
        batch = compared(ours, theirs)
        results[f"mapped_{name}_state_vs_own_layout"] = {
            "ours_us": batch["ours_us"] / BATCH,
            "theirs_us": batch["theirs_us"] / BATCH,
            "ratio": batch["ratio"],
        }
    batch = compared(packets(), own(True))
    results["mapped_packet_state_vs_own_layout"] = {
        "ours_us": batch["ours_us"] / BATCH,
        "theirs_us": batch["theirs_us"] / BATCH,
        "ratio": batch["ratio"],
    }
    return results


PACKETS = """
[packets.tip]
start = "AA"
length = 28
checksum = { kind = "x25", signal = "crc", first = 1 }
counter = "n"
[packets.tip.fields]
n = "u8 @1"
fz = "f32 le @2 * 1 N"
fx = "f32 le @6 * 1 N"
fy = "f32 le @10 * 1 N"
tz = "f32 le @14 * 1 mN*m"
depth = "f32 le @18 * 1 mm"
slip = "f32 le @22"
crc = "u16 le @26"
"""


def packets() -> Callable[[], object]:
    """Decode a batch of packets as they come from a serial line, one a read."""
    names = dict(zip(("fz", "fx", "fy", "tz", "depth", "slip"), CHANNELS.values(), strict=True))
    tables = [f'[fingers.thumb.{c}]\nsignal = "tip.{s}"\nzero_is_measured = true' for s, c in names.items()]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hand.toml"
        path.write_text(PACKETS + "\n".join(tables))
        codec = MappedCodec(open_plan(path))
    stream = PacketStream(codec.plan.database.packets, Counter())
    sent = []
    for seq in range(BATCH):
        body = struct.pack("<B6f", seq % 256, 4.0, 0.5, -0.25, 2.0, 1.0, 0.0)
        sent.append(
            b"\xaa" + body + make_crc(16, 0x1021, 0xFFFF, 0xFFFF, reflected=True)(body).to_bytes(2, "little")
        )

    def decode() -> int:
        begin_again(*codec._sequences)
        return sum(
            len(codec.decode_all(frame))
            for seq, packet in enumerate(sent)
            for frame in stream.feed(packet, seq * MILLISECOND + 1)
        )

    assert decode() == BATCH
    return decode


def begin_again(*sequences: Counted) -> None:
    """Take the next message as the first one."""
    for sequence in sequences:
        sequence.last = -1


def own(fd: bool) -> Callable[[], object]:
    """Decode a batch of our own frames; classic states take two."""
    sender, receiver = CanCodec(("thumb",), fd=fd), CanCodec(("thumb",), fd=fd)
    sent = [frame for seq in range(BATCH) for frame in sender.encode(state(seq))]

    def decode() -> int:
        begin_again(*(decoder.assembly.sequence for decoder in receiver._decoders.values()))
        return sum(receiver.decode(frame) is not None for frame in sent)

    assert decode() == BATCH
    return decode


def state(seq: int) -> FingertipState:
    return FingertipState(seq * MILLISECOND, "thumb", seq, 4.0, 0.5, -0.25, 0.002, 0.001, slip=0.0)


def mapped(database: str, checksum: dict[str, object]) -> Callable[[], object]:
    """Decode a batch of foreign frames."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        (path / "theirs.dbc").write_text(database)
        (path / "hand.toml").write_text(text(database, checksum))
        codec = MappedCodec(open_plan(path / "hand.toml"))
    sent = frames(codec, checksum)

    def decode() -> int:
        begin_again(*codec._sequences)
        return sum(len(codec.decode_all(frame)) for frame in sent)

    assert decode() == BATCH
    return decode


def text(database: str, checksum: dict[str, object]) -> str:
    names = [line.split()[2].rstrip(":") for line in database.splitlines() if line.startswith("BO_ ")]
    table = ", ".join(f"{key} = {value!r}".replace("'", '"') for key, value in checksum.items())
    lines = ['database = "theirs.dbc"']
    for name in names:
        lines += [f"[messages.{name}]", 'counter = "Cnt"', f"checksum = {{ {table} }}"]
    lines += ["[fingers.thumb]", f'trigger = "{names[-1]}"']
    for signal, channel in CHANNELS.items():
        message = names[0] if signal in ("Fz", "Fx", "Fy") else names[-1]
        lines += [f"[fingers.thumb.{channel}]", f'signal = "{message}.{signal}"', "zero_is_measured = true"]
        lines += ["sign = -1"] if signal == "Depth" else []
    return "\n".join(lines)


def frames(codec: MappedCodec, checksum: dict[str, object]) -> Sequence[Frame]:
    spec = ChecksumMap(**checksum)  # type: ignore[arg-type]
    sent = []
    for seq in range(BATCH):
        for name in codec.plan.messages:
            message = codec.plan.database.messages[name]
            signals = {name: one for name, one in message.signals.items() if name in VALUES}
            raws = {name: rounding(one)(VALUES[name])[0] for name, one in signals.items()}
            packed = packing(message, {**raws, "Cnt": seq % 256})
            data = bytearray(made(["def packed():", f" return {packed}"], "packed", {})())
            guard = protection(spec, message, name)
            assert guard is not None
            guard.protect(data)
            sent.append(Frame(message.identifier, bytes(data), message.fd, seq * MILLISECOND + 1))
    return sent
