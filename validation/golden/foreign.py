"""A hand of another make: its database, its map, and the device itself, by cantools."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cantools.database
import numpy as np

from validation.golden.events import CHANNELS, Event
from vegrip.messages import ForceCommand, Reason

LOAD, MOTION, SET = 0x100, 0x110, 0x200
HEAD = 'VERSION ""\nNS_ :\nBS_:\nBU_: Hand X\n'
DBC = """BO_ {load} Load{n}: 8 Hand
 SG_ Fz{n} : 0|16@1- (0.002,0) [-65|65] "N" X
 SG_ Fx{n} : 16|16@1- (0.002,0) [-65|65] "N" X
 SG_ Fy{n} : 32|16@1- (0.002,0) [-65|65] "N" X
 SG_ Cnt : 48|4@1+ (1,0) [0|15] "" X
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" X
BO_ {motion} Motion{n}: 8 Hand
 SG_ Depth{n} : 7|16@0- (0.0002,0) [-6.5|6.5] "mm" X
 SG_ Tz{n} : 16|16@1- (0.00002,0) [-0.6|0.6] "Nm" X
 SG_ Slip{n} : 32|1@1+ (1,0) [0|1] "" X
 SG_ Speed{n} : 40|8@1+ (0.1,0) [0|25] "mm/s" X
 SG_ Cnt : 48|4@1+ (1,0) [0|15] "" X
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" X
BO_ {set} Set{n}: 8 X
 SG_ Grip{n} : 0|16@1+ (0.001,0) [0|60] "N" Hand
 SG_ Enable : 16|1@1+ (1,0) [0|1] "" Hand
 SG_ Cnt : 48|4@1+ (1,0) [0|15] "" Hand
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" Hand
"""
CRC = '{ kind = "crc8", signal = "Crc", polynomial = 0x2F, start = 0xFF, final = 0xFF }'
GUARDED = '[messages.{name}]\ncounter = "Cnt"\nchecksum = {crc}\n'
FINGER = """[fingers.{finger}.normal_force]
signal = "Load{n}.Fz{n}"
[fingers.{finger}.tangential_force_x]
signal = "Load{n}.Fx{n}"
[fingers.{finger}.tangential_force_y]
signal = "Load{n}.Fy{n}"
[fingers.{finger}.displacement]
signal = "Motion{n}.Depth{n}"
[fingers.{finger}.torque_z]
signal = "Motion{n}.Tz{n}"
[fingers.{finger}.slip]
signal = "Motion{n}.Slip{n}"
[fingers.{finger}.slip_speed]
signal = "Motion{n}.Speed{n}"
[fingers.{finger}.command]
signal = "Set{n}.Grip{n}"
set = {{ Enable = 1 }}
"""
UNIT = {"normal_force": 1.0, "displacement": 1e3, "torque_z": 1.0, "slip_speed": 1e3}
PLACES = {
    "Fz": "normal_force", "Fx": "tangential_force_x", "Fy": "tangential_force_y", "Depth": "displacement",
    "Tz": "torque_z", "Slip": "slip", "Speed": "slip_speed",
}  # fmt: skip


def crc8(data: bytes) -> int:
    """Return the checksum of their messages, bit by bit."""
    register = 0xFF
    for byte in data:
        register ^= byte
        for _ in range(8):
            register = (register << 1 ^ 0x2F if register & 0x80 else register << 1) & 0xFF
    return register ^ 0xFF


class ForeignHand:
    """The device with ``fingers``."""

    def __init__(self, fingers: Sequence[str]) -> None:
        self.fingers = tuple(fingers)
        numbers = range(len(fingers))
        self._dbc = HEAD + "".join(
            DBC.format(n=n, load=LOAD + n, motion=MOTION + n, set=SET + n) for n in numbers
        )
        self._database = cantools.database.load_string(self._dbc, "dbc")
        self._seq = [0] * len(fingers)

    def written(self, folder: Path) -> Path:
        """Write database and map; return the path of the map."""
        folder.mkdir(parents=True, exist_ok=True)
        count = len(self.fingers)
        lines = [f'database = "hand{count}.dbc"\nrate = 200.0\n']
        names = [f"{kind}{n}" for n in range(count) for kind in ("Load", "Motion", "Set")]
        lines += [GUARDED.format(name=name, crc=CRC) for name in names]
        lines += [FINGER.format(n=n, finger=finger) for n, finger in enumerate(self.fingers)]
        for path, text in (
            (folder / f"hand{count}.dbc", self._dbc),
            (folder / f"hand{count}.toml", "\n".join(lines)),
        ):
            if not path.exists() or path.read_text() != text:
                path.write_text(text)
        return folder / f"hand{count}.toml"

    def frames(self, event: Event) -> list[tuple[int, bytes]]:
        """Return the frames of a state; what is not measured is said as the least value of its signal."""
        values = dict(zip(CHANNELS, event.values, strict=True))
        found = []
        for identifier, kind in ((LOAD + event.finger, "Load"), (MOTION + event.finger, "Motion")):
            message = self._database.get_message_by_frame_id(identifier)  # type: ignore[union-attr]
            raw: dict[str, int | float] = {"Cnt": event.seq % 16, "Crc": 0}
            for signal in message.signals:
                channel = PLACES.get(signal.name.rstrip("0123456789"))
                if channel is not None:
                    raw[signal.name] = _raw(signal, values[channel] * UNIT.get(channel, 1.0))
            data = bytearray(message.encode(raw, scaling=False, strict=False))
            data[7] = crc8(bytes(data[:7]))
            found.append((identifier, bytes(data)))
            del kind
        return found

    def command(self, identifier: int, data: bytes, at: int) -> ForceCommand | None:
        """Return what a frame asks a finger for."""
        finger = identifier - SET
        if not 0 <= finger < len(self.fingers):
            return None
        values: Any = self._database.decode_message(identifier, data, scaling=True)  # type: ignore[union-attr]
        self._seq[finger] += 1
        force = float(values[f"Grip{finger}"])
        return ForceCommand(at, self.fingers[finger], self._seq[finger], force, 0.0, Reason.HOLD, at)


def _raw(signal: cantools.database.Signal, value: float) -> int:
    low, high = (
        (-(1 << signal.length - 1), (1 << signal.length - 1) - 1)
        if signal.is_signed
        else (0, (1 << signal.length) - 1)
    )
    if np.isnan(value):
        return low
    return int(min(max(np.rint(value / float(signal.scale)), low), high))
