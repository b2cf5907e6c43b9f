"""Simulated Robotiq grippers of two fingers: Modbus RTU, and the lines of the URCap at TCP port 63352.

Variables and their values are those of the maker's manual; a force takes effect when a motion begins.
"""

import math
import struct
from typing import Final

from vegrip.clock import NS
from vegrip.transport.hands.virtual_drive import NO_FRAME, VirtualDrive
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.maps.checksums import appended

UNIT: Final = 9
OUTPUTS, INPUTS, REGISTERS = 0x03E8, 0x07D0, 3
ACTIVATION_NS: Final = NS // 10  # of a real one: some seconds
SLOWEST, FASTEST = 60.0, 450.0  # [counts/s] 20 and 150 mm/s of 85 mm in 255 counts (data sheet of the 2F-85)
RESET, IN_PROGRESS, ACTIVE = 0, 1, 3
MOVING, MET_CLOSING, THERE = 0, 2, 3
NOT_ACTIVATED: Final = 7
CURRENT: Final = 20  # [10 mA] while it holds
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS = 1, 2
FLAGS: Final = {"ACT": 0, "GTO": 3, "ATR": 4, "ARD": 5}  # bits of the first byte of the outputs
VALUES: Final = {"POS": 3, "SPE": 4, "FOR": 5}  # bytes of the outputs


class Robotiq(VirtualDrive):
    """What both protocols speak of."""

    def __init__(self, plan: Plan, latency: float = 0.0) -> None:
        super().__init__(plan, latency)
        self.commanded = dict.fromkeys((*FLAGS, *VALUES), 0)
        self.fault = 0
        self._force = 0  # that the present motion began with
        self._ready_at: int | None = None  # [ns]

    @property
    def state(self) -> int:
        return RESET if not self.commanded["ACT"] else IN_PROGRESS if self._ready_at is not None else ACTIVE

    @property
    def object(self) -> int:
        return MOVING if self.jaws.moves else MET_CLOSING if self.jaws.holds else THERE

    def go(self, now: int) -> None:
        if self._ready_at is not None and now >= self._ready_at:
            self._ready_at = None
        self.jaws.go(now)

    def tell(self, values: dict[str, int], now: int) -> None:
        """Take the variables that were set."""
        before, self.commanded = self.commanded, self.commanded | values
        if self.commanded["ACT"] != before["ACT"]:
            self._ready_at = now + ACTIVATION_NS if self.commanded["ACT"] else None
            self.fault = 0
        wants_motion = self.commanded["GTO"] and (not before["GTO"] or self.commanded["POS"] != before["POS"])
        if self.state != ACTIVE:
            self.fault = NOT_ACTIVATED if wants_motion and self.state == RESET else self.fault
            return
        if wants_motion:
            self._force = self.commanded["FOR"]
        if self.commanded["GTO"]:
            self.jaws.target = float(self.commanded["POS"])
            self.jaws.speed = SLOWEST + (FASTEST - SLOWEST) * self.commanded["SPE"] / 255
        else:
            self.jaws.target = self.jaws.place

    def pressed(self) -> float:
        if self.state != ACTIVE or not self.commanded["GTO"]:
            return math.nan
        low, high = self.limits.minimum, self.limits.maximum
        return low + (high - low) * self._force / 255 if self.commanded["POS"] else 0.0

    def inputs(self) -> bytes:
        status = self.commanded["ACT"] | self.commanded["GTO"] << 3 | self.state << 4 | self.object << 6
        current = CURRENT if self.jaws.holds else 0
        return bytes([status, 0, self.fault, self.commanded["POS"], round(self.jaws.place), current])


class RobotiqRtu(Robotiq):
    """Slave 9 of a serial line: functions 3, 4, 6, 16 and 23; another's requests are not answered."""

    def answered(self, data: bytes, now: int) -> tuple[int, bytes]:
        if len(data) < 8:
            return NO_FRAME, b""
        unit, function, first, count = struct.unpack_from(">BBHH", data)
        size = {16: 9 + data[6], 23: 13 + (data[10] if len(data) > 10 else 255)}.get(function, 8)
        if len(data) < size:
            return (NO_FRAME, b"") if size <= 255 else (1, b"")
        if appended("modbus", data[: size - 2]) != data[:size]:
            self.counts["unknown_request"] += 1
            return 1, b""
        if unit != UNIT:
            return size, b""
        answer = self._answer(function, first, count, data[:size], now)
        is_refused = len(answer) == 1
        body = bytes([UNIT, function | is_refused << 7]) + answer
        return size, appended("modbus", body)

    def _answer(self, function: int, first: int, count: int, data: bytes, now: int) -> bytes:
        """Return what follows the function; one byte is an exception."""
        if function in (3, 4):
            return self._read(first, count)
        also = int.from_bytes(data[6:8], "big")  # where function 23 writes
        writes = {6: (first, data[4:6]), 16: (first, data[7:-2]), 23: (also, data[11:-2])}
        if function not in writes:
            return bytes([ILLEGAL_FUNCTION])
        if not self._write(*writes[function], now):
            return bytes([ILLEGAL_ADDRESS])
        return self._read(first, count) if function == 23 else data[2:6]

    def _read(self, first: int, count: int) -> bytes:
        here = {INPUTS: self.inputs(), OUTPUTS: self._outputs()}
        for begin, data in here.items():
            if begin <= first and first + count <= begin + REGISTERS:
                return bytes([2 * count]) + data[2 * (first - begin) : 2 * (first - begin + count)]
        return bytes([ILLEGAL_ADDRESS])

    def _outputs(self) -> bytes:
        action = sum(self.commanded[name] << bit for name, bit in FLAGS.items())
        return bytes([action, 0, 0, *(self.commanded[name] for name in VALUES)])

    def _write(self, first: int, data: bytes, now: int) -> bool:
        at = 2 * (first - OUTPUTS)
        if at < 0 or at + len(data) > 2 * REGISTERS:
            return False
        outputs = bytearray(self._outputs())
        outputs[at : at + len(data)] = data
        flags = {name: outputs[0] >> bit & 1 for name, bit in FLAGS.items()}
        self.tell(flags | {name: outputs[at] for name, at in VALUES.items()}, now)
        return True


class RobotiqUrcap(Robotiq):
    """The lines of a UR arm: GET of a variable, SET of one or several."""

    def answered(self, data: bytes, now: int) -> tuple[int, bytes]:
        line, end, _ = data.partition(b"\n")
        if not end:
            return NO_FRAME, b""
        words = line.decode("latin-1").split()
        names, numbers = words[1::2], words[2::2]
        if words[:1] == ["GET"] and len(words) == 2 and words[1] in self._variables():
            return len(line) + 1, f"{words[1]} {self._variables()[words[1]]}\n".encode()
        is_whole = len(names) == len(numbers) > 0 and set(names) <= self.commanded.keys()
        is_sound = all(number.isdecimal() and int(number) <= 255 for number in numbers)
        if words[:1] == ["SET"] and is_whole and is_sound:
            self.tell(dict(zip(names, map(int, numbers), strict=True)), now)
            return len(line) + 1, b"ack"
        self.counts["unknown_request"] += 1
        return len(line) + 1, b""

    def _variables(self) -> dict[str, int]:
        commanded = {"STA": self.state, "OBJ": self.object, "FLT": self.fault, "PRE": self.commanded["POS"]}
        return {**self.commanded, **commanded, "POS": round(self.jaws.place)}
