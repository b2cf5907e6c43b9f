"""A simulated Dynamixel X with two fingers on it: protocol 2.0, the part of its control table that is used.

In current-based position mode it runs to its goal position with no more than its goal current.
"""

import math
import struct
from typing import Final

from vegrip.transport.hands.virtual_drive import FramedDrive
from vegrip.transport.mapped.commands import law_of
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.maps.checksums import appended

HEAD: Final = b"\xff\xff\xfd\x00"
STUFFED, UNSTUFFED = b"\xff\xff\xfd\xfd", b"\xff\xff\xfd"
PING, READ, WRITE, STATUS = 1, 2, 3, 0x55
INSTRUCTION_ERROR, CRC_ERROR, LENGTH_ERROR, ACCESS_ERROR, ALERT = 2, 3, 5, 7, 0x80
SIZE: Final = 147  # [bytes] of the table that is simulated
MODEL: Final = b"\xfc\x03"  # 1020, an XM430-W350
MODE, TORQUE, ERRORS, GOAL_CURRENT, GOAL, CURRENT, POSITION = 11, 64, 70, 102, 116, 126, 132
CURRENT_BASED_POSITION: Final = 5
OWN_SPEED: Final = 4000.0  # [counts/s] 60 rpm of 4096 counts


class Dynamixel(FramedDrive):
    """Id 1 of its line."""

    ident = 1
    head, length_at, around, checksum = HEAD, 5, 7, "dynamixel"

    def __init__(self, plan: Plan, latency: float = 0.0) -> None:
        super().__init__(plan, latency)
        self.table = bytearray(SIZE)
        self.table[0:2], self.table[MODE] = MODEL, 3  # delivered in position mode
        name = self._fingers[0]
        command = plan.hand.fingers[name].command
        assert command is not None  # noqa: S101 (it is a drive)
        self._law = law_of(command, command.unit, name)
        self._opened, closed = command.opened, command.closed[0]
        self._sign = 1 if closed > self._opened else -1
        self.jaws.place = self.jaws.target = 0.0  # counts from open to closed

    def go(self, now: int) -> None:
        self.jaws.speed = OWN_SPEED if self.table[TORQUE] else 0.0
        self.jaws.go(now)
        self._put(POSITION, "<i", self._opened + self._sign * round(self.jaws.place))
        (current,) = struct.unpack_from("<h", self.table, GOAL_CURRENT)
        self._put(CURRENT, "<h", self._sign * current if self.jaws.holds else 0)

    def pressed(self) -> float:
        if not self.table[TORQUE] or self.table[MODE] != CURRENT_BASED_POSITION:
            return math.nan
        (current,) = struct.unpack_from("<h", self.table, GOAL_CURRENT)
        return self._law.force(current, math.nan, math.nan, math.nan) if self.jaws.target > 0.0 else 0.0

    def answer(self, body: bytes, *, is_sound: bool) -> bytes:
        if body[4] not in (self.ident, 0xFE):
            return b""
        return (
            self._obey(body[7], body[8:].replace(STUFFED, UNSTUFFED)) if is_sound else self._status(CRC_ERROR)
        )

    def _obey(self, instruction: int, parameters: bytes) -> bytes:
        if instruction == PING:
            return self._status(0, bytes(self.table[:2]) + b"\x2e")
        if instruction not in (READ, WRITE):
            return self._status(INSTRUCTION_ERROR)
        at = int.from_bytes(parameters[:2], "little")
        if instruction == READ:
            count = int.from_bytes(parameters[2:4], "little")
            if at + count > SIZE:
                return self._status(LENGTH_ERROR)
            return self._status(0, bytes(self.table[at : at + count]))
        is_locked = at < TORQUE and self.table[TORQUE]  # what is kept without power
        is_there = at + len(parameters) - 2 <= SIZE
        if is_there and not is_locked:
            self._write(at, parameters[2:])
        return self._status(ACCESS_ERROR if is_locked else 0 if is_there else LENGTH_ERROR)

    def _write(self, at: int, data: bytes) -> None:
        before = self.table[TORQUE]
        self.table[at : at + len(data)] = data
        if self.table[TORQUE] and not before:  # it stays where it is
            self._put(GOAL, "<i", self._opened + self._sign * round(self.jaws.place))
        if self.table[TORQUE]:
            (goal,) = struct.unpack_from("<i", self.table, GOAL)
            self.jaws.target = float(self._sign * (goal - self._opened))

    def _put(self, at: int, form: str, value: int) -> None:
        struct.pack_into(form, self.table, at, value)

    def _status(self, error: int, data: bytes = b"") -> bytes:
        error |= ALERT if self.table[ERRORS] else 0
        inner = (bytes([STATUS, error]) + data).replace(UNSTUFFED, STUFFED)
        return appended("dynamixel", HEAD + struct.pack("<BH", self.ident, len(inner) + 2) + inner)
