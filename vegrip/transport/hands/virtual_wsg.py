"""A simulated WSG 50 of Weiss Robotics: messages of TCP port 1000."""

import math
import struct
from typing import Final

from vegrip.transport.hands.virtual_drive import FramedDrive
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.maps.checksums import appended

HEAD: Final = b"\xaa\xaa\xaa"
OPEN_MM: Final = 110.0  # [mm] its stroke
SUCCESS, NOT_INITIALIZED, CHECKSUM_ERROR, UNKNOWN, FORMAT_ERROR = 0, 3, 11, 14, 15
ACCESS_DENIED, PENDING, RANGE_ERROR = 16, 26, 28
IDLE, GRIPPING, NO_PART, LOST, HOLDING, RELEASING = range(6)
GOODBYE, HOMING, ACKNOWLEDGE, GRIP, RELEASE, LIMIT = 0x07, 0x20, 0x24, 0x25, 0x26, 0x32
SYSTEM, GRASP, WIDTH, FORCE = 0x40, 0x41, 0x43, 0x45
LENGTHS: Final = {GOODBYE: 0, HOMING: 1, ACKNOWLEDGE: 3, GRIP: 8, RELEASE: 8, LIMIT: 4} | dict.fromkeys(
    (SYSTEM, GRASP, WIDTH, FORCE), 3
)
"""Of the payload of each message that is understood [bytes]."""


class Wsg(FramedDrive):
    """Jaws whose places are [mm] closed from fully open."""

    head, length_at, around, checksum = HEAD, 4, 8, "weiss"

    def __init__(self, plan: Plan, latency: float = 0.0) -> None:
        super().__init__(plan, latency)
        self.is_referenced = self.is_stopped = False
        self.limit = 10.0  # [N] of the grip that comes next
        self._grips_with = math.nan  # [N]
        self.grasp = IDLE

    def go(self, now: int) -> None:
        self.jaws.go(now)
        if self.grasp == GRIPPING:
            self.grasp = HOLDING if self.jaws.holds else GRIPPING if self.jaws.moves else NO_PART
        elif self.grasp == HOLDING and not self.jaws.holds:
            self.grasp = LOST
        elif self.grasp == RELEASING and not self.jaws.moves:
            self.grasp = IDLE

    def pressed(self) -> float:
        return self._grips_with

    def answer(self, body: bytes, *, is_sound: bool) -> bytes:
        what, payload = body[3], body[6:]
        if not is_sound:
            return _message(what, CHECKSUM_ERROR)
        if what not in LENGTHS:
            self.counts["unknown_request"] += 1
            return _message(what, UNKNOWN)
        return self._obey(what, payload) if len(payload) == LENGTHS[what] else _message(what, FORMAT_ERROR)

    def _obey(self, what: int, payload: bytes) -> bytes:
        state = {
            SYSTEM: struct.pack("<I", self.is_referenced | self.is_stopped << 12),
            GRASP: bytes([self.grasp]),
            WIDTH: struct.pack("<f", OPEN_MM - self.jaws.place),
            FORCE: struct.pack("<f", self._grips_with if self.jaws.holds else 0.0),
        }
        if what in state:
            return _message(what, SUCCESS, state[what])
        if what == ACKNOWLEDGE:
            self.is_stopped = self.is_stopped and payload != b"ack"
            return _message(what, SUCCESS if payload == b"ack" else FORMAT_ERROR)
        if what == HOMING:
            self.is_referenced = not self.is_stopped
            return _message(what, PENDING) + _message(what, SUCCESS)
        if what == LIMIT:
            (limit,) = struct.unpack("<f", payload)
            is_sound = self.limits.minimum <= limit <= self.limits.maximum
            self.limit = limit if is_sound else self.limit
            return _message(what, SUCCESS if is_sound else RANGE_ERROR)
        return self._move(what, payload) if what in (GRIP, RELEASE) else _message(what, SUCCESS)

    def _move(self, what: int, payload: bytes) -> bytes:
        if self.is_stopped or not self.is_referenced:
            return _message(what, ACCESS_DENIED if self.is_stopped else NOT_INITIALIZED)
        width, speed = struct.unpack("<2f", payload)
        self.jaws.target, self.jaws.speed = OPEN_MM - width, speed
        self.grasp = GRIPPING if what == GRIP else RELEASING
        self._grips_with = self.limit if what == GRIP else 0.0
        return _message(what, PENDING)


def _message(what: int, status: int, data: bytes = b"") -> bytes:
    return appended("weiss", HEAD + struct.pack("<BHH", what, 2 + len(data), status) + data)
