"""All fingers of a hand in one compiled call: states that come together in, their commands together out.

A row is answered exactly as :meth:`~vegrip.grip.finger.GraspFinger.step` answers its frame, in the order of
the rows. Where C runs the step, ``rows.c`` goes through them; else Python does so here.
"""

import ctypes
import struct
from collections.abc import Sequence
from typing import Any, Final, NamedTuple, cast

import numpy as np

from vegrip.grip.finger import GraspFinger
from vegrip.grip.wires import COMMAND_BYTES, COMMANDED, LEFT_ALONE, REPORT_BYTES, STATE_BYTES
from vegrip.model.native import ModuleC
from vegrip.transport.canbus.frame_time import FD_SIZES
from vegrip.transport.canbus.hub_wire import (
    DELIVERY,
    MOST_REQUESTS,
    PLAIN_FLAGS,
    RATE_SWITCH,
    REQUEST,
    REQUEST_AT,
    pack_request,
)
from vegrip.transport.canbus.virtual_can import Taken
from vegrip.transport.codec.batch_codec import FIRST_ROW, MAX_BATCH_ROWS, ROW_ID, ROW_STRIDE
from vegrip.types import Floats

_POINTER, _WHOLE = ctypes.c_void_p, ctypes.c_int64
ROWS_ARGUMENTS: Final = (
    *[_POINTER] * 4, *[_WHOLE] * 3, ctypes.c_char_p, _POINTER, *[_WHOLE] * 3, *[_POINTER] * 2,
)  # fmt: skip
STATE_ROW: Final = ROW_ID.size + STATE_BYTES
CONTACT_ROW: Final = ROW_ID.size + REPORT_BYTES[0]
MARGIN_ROW: Final = ROW_ID.size + REPORT_BYTES[2]
IDENTIFIERS: Final = 2048  # of a frame with 11 bits
LONGEST_FRAME: Final = 64  # [bytes]
MOST_ROWS: Final = 256
MOST_COMMANDS: Final = max(MAX_BATCH_ROWS, MOST_REQUESTS)  # a batch may have two states of a finger
ROW: Final = struct.Struct("=4q")  # finger, begin, length, arrival [ns]
ROWS: Final = [struct.Struct(f"={4 * rows}q") for rows in range(MOST_REQUESTS + 1)]
TIME: Final = struct.Struct("<Q")
HEAD_BYTES: Final = DELIVERY.size
CODES: Final = len(FD_SIZES)
read_head: Final = DELIVERY.unpack_from


class PacketAnswer(NamedTuple):
    """What was done with the first frames of a packet, each the state of another finger."""

    taken: Taken
    commands: int
    requests: memoryview  # that ask the bus to send them; valid until the next packet
    states: Sequence[tuple[str, int, int]]  # finger, what was done in bits, and arrival [ns]


class CompiledRows:
    """The compiled steps of all fingers, called at once.

    Args:
        fingers: whose frames come as rows.
        needs: what every finger needs [N]; the array that the steps share.
        heads: what stands before the commands of each, all as long.
        first: where the first command stands in :attr:`commands`.

    """

    def __init__(
        self, fingers: Sequence[GraspFinger], needs: Floats, heads: Sequence[bytes], first: int
    ) -> None:
        self.fingers = tuple(fingers)
        self.commands = bytearray(first + MOST_COMMANDS * (len(heads[0]) + COMMAND_BYTES))
        """The last commands, behind room for what comes first."""
        self._done = bytearray(MOST_ROWS)
        self._rows = np.zeros((MOST_ROWS, 4), dtype=np.int64)
        self._row_bytes = self._rows.data.cast("B")
        self._heads, self._first, self._frame = heads, first, np.zeros(LONGEST_FRAME, dtype=np.uint8)
        self._call: Any = None
        if isinstance(fingers[0].numbers.module, ModuleC):
            self._bind(fingers[0].numbers.module, needs)

    def _go_through(self, data: bytes, rows: int, now: int, *, stops: bool) -> int:
        """Answer the first ``rows``; return how many commands there are.

        With ``stops`` nothing behind a row that is left alone is looked at.
        """
        if self._call is not None:
            commands: int = self._call(data, rows, stops, now)
            return commands
        commands, size = 0, len(self._heads[0]) + COMMAND_BYTES
        for row, (number, at, length, arrival) in enumerate(self._rows[:rows].tolist()):
            done = LEFT_ALONE
            if number >= 0:
                self._frame[:length] = np.frombuffer(data, np.uint8, length, at)
                done = self.fingers[number].step(self._frame, length, arrival, now)
            if done & COMMANDED:
                start = self._first + commands * size
                answer = self._heads[number] + self.fingers[number].numbers.answer_frame.tobytes()
                self.commands[start : start + size] = answer
                commands += 1
            self._done[row] = done
            if stops and done == LEFT_ALONE:
                break
        return commands

    def _bind(self, module: ModuleC, needs: Floats) -> None:
        kinds = ctypes.c_void_p * len(self.fingers)
        reals = kinds(*[finger.memory.f.ctypes.data for finger in self.fingers])
        wholes = kinds(*[finger.memory.t.ctypes.data for finger in self.fingers])
        heads = ctypes.create_string_buffer(b"".join(self._heads))
        kept = (ctypes.addressof(reals), ctypes.addressof(wholes), needs.ctypes.data, ctypes.addressof(heads))
        sizes = len(self._heads[0]), COMMAND_BYTES, COMMANDED
        table, step = self._rows.ctypes.data, cast("Any", module.loaded.vg_rows_step)
        step.argtypes, step.restype = ROWS_ARGUMENTS, ctypes.c_int64
        answers, outcome = _address(self.commands, self._first), _address(self._done)

        def call(data: bytes, rows: int, stops: bool, now: int) -> int:
            commands: int = step(*kept, *sizes, data, table, rows, stops, now, answers, outcome)
            return commands

        self._call, self._lives = call, (reals, wholes, heads, needs)


class CompiledBatch(CompiledRows):
    """Rows of a batch; reports of the fingers leave as batches, too."""

    def __init__(self, fingers: Sequence[GraspFinger], needs: Floats) -> None:
        heads = [ROW_ID.pack(finger.numbers.on_wire.command_id) for finger in fingers]
        super().__init__(fingers, needs, heads, FIRST_ROW)
        self.contacts = bytearray(FIRST_ROW + len(fingers) * 2 * CONTACT_ROW)
        """The batch of the last contacts; its head is still to be written, as that of :attr:`commands`."""
        self.margins = bytearray(FIRST_ROW + len(fingers) * MARGIN_ROW)
        """The batch of the last slip margins, likewise."""
        self._numbers = {finger.numbers.on_wire.state_id: number for number, finger in enumerate(fingers)}
        self._named = {finger.name: finger for finger in fingers}
        self._identifiers = b"", b""  # of the rows that came last, low and high bytes,
        self._names: list[str] = []  # and whose they are

    def step(self, payload: bytes, rows: int, arrival: int, now: int) -> tuple[bytearray, int]:
        """Answer the ``rows`` of a batch that is whole, which arrived at ``arrival`` at ``now`` [ns].

        Returns:
            What was done with each row, in bits (more items than rows), and how many commands there are.

        """
        self.names_in(payload, rows)
        self._rows[:rows, 3] = arrival
        return self._done, self._go_through(payload, rows, now, stops=False)

    def names_in(self, payload: bytes, rows: int) -> Sequence[str]:
        """Return whose states the rows are, "" for another one's; mostly they come in the same order."""
        end = FIRST_ROW + rows * STATE_ROW
        low, high = (slice(FIRST_ROW + byte, end, STATE_ROW) for byte in range(ROW_ID.size))
        identifiers = payload[low], payload[high]
        if identifiers != self._identifiers:
            self._identifiers = identifiers
            owners = [self._numbers.get(a + 256 * b, -1) for a, b in zip(*identifiers, strict=True)]
            self._names = ["" if number < 0 else self.fingers[number].name for number in owners]
            for row, number in enumerate(owners):
                begin = FIRST_ROW + row * STATE_ROW + ROW_ID.size
                ROW.pack_into(self._row_bytes, row * ROW.size, number, begin, STATE_BYTES, 0)
        return self._names

    def finger_of(self, payload: bytes, row: int) -> GraspFinger | None:
        """Return whose state a row is, None for another one's."""
        (identifier,) = ROW_ID.unpack_from(payload, FIRST_ROW + row * STATE_ROW)
        number = self._numbers.get(identifier)
        return None if number is None else self.fingers[number]

    def report(self, names: Sequence[str], now: int) -> list[str]:
        """Pack contacts and slip margins of fingers by their names; return those packed, in that order."""
        packed: list[str] = []
        for name in names:
            finger = self._named[name]
            if not finger.numbers.report_as_frames(now):
                continue
            rows = [
                ROW_ID.pack(identifier) + frame.tobytes()
                for identifier, frame in zip(
                    finger.numbers.on_wire.report_ids, finger.numbers.report_frames, strict=True
                )
            ]
            at, margin = FIRST_ROW + len(packed) * 2 * CONTACT_ROW, FIRST_ROW + len(packed) * MARGIN_ROW
            self.contacts[at : at + 2 * CONTACT_ROW] = rows[0] + rows[1]
            self.margins[margin : margin + MARGIN_ROW] = rows[2]
            packed.append(name)
        return packed


class CompiledPackets(CompiledRows):
    """Frames of a packet of the virtual bus; their commands leave as requests to it."""

    def __init__(self, fingers: Sequence[GraspFinger], needs: Floats) -> None:
        heads = [
            pack_request(0, f.numbers.on_wire.command_id, bytes(COMMAND_BYTES), PLAIN_FLAGS) for f in fingers
        ]
        super().__init__(fingers, needs, [head[: REQUEST.size] for head in heads], 0)
        self._numbers = {finger.numbers.on_wire.state_id: number for number, finger in enumerate(fingers)}
        self._names = [finger.name for finger in fingers]
        self._requests, self._size = memoryview(self.commands), REQUEST.size + COMMAND_BYTES

    def step(self, packet: bytes, expected: int, now: int) -> PacketAnswer | None:
        """Answer the states at the beginning of a packet, each of another finger; None: it begins with none.

        Args:
            packet: of numbered deliveries.
            expected: number of its first one, if none was lost.
            now: [ns].

        """
        found: list[tuple[int, int, int, int, int]] = []  # number, end, busy, finger, where the next begins
        rows: list[int] = []
        seen, at, length = 0, 0, len(packet)
        while length - at >= HEAD_BYTES and len(found) < MOST_REQUESTS:
            number, end, busy, _, identifier, flags, code = read_head(packet, at)
            finger = self._numbers.get(identifier, -1)
            if finger < 0 or seen >> finger & 1 or flags | RATE_SWITCH != PLAIN_FLAGS or code >= CODES:
                break
            rows += (finger, at + HEAD_BYTES, FD_SIZES[code], end)
            at += HEAD_BYTES + FD_SIZES[code]
            if at > length:
                break
            seen |= 1 << finger
            found.append((number, end, busy, finger, at))
        if not found:
            return None
        ROWS[len(found)].pack_into(self._row_bytes, 0, *rows[: 4 * len(found)])
        commands = self._go_through(packet, len(found), now, stops=True)
        answered = self._done.find(LEFT_ALONE, 0, len(found))
        if answered == 0:
            return None
        states, lost, done = [], 0, self._done
        found = found[:answered] if answered > 0 else found
        for row, (number, end, _, finger, _) in enumerate(found):
            lost += (number - expected) & 0xFFFFFFFF
            expected = (number + 1) & 0xFFFFFFFF
            states.append((self._names[finger], done[row], end))
        for begin in range(0, commands * self._size, self._size):
            TIME.pack_into(self.commands, begin + REQUEST_AT["time"], now)
        _, end, busy, _, size = found[-1]
        taken = Taken(size, lost, expected, end, busy)
        return PacketAnswer(taken, commands, self._requests[: commands * self._size], states)


def _address(data: bytearray, at: int = 0) -> int:
    """Return where ``data`` lies, which may not become longer from then on."""
    return ctypes.addressof(ctypes.c_uint8.from_buffer(data, at))


def join(fingers: Sequence[GraspFinger], needs: Floats) -> CompiledBatch | CompiledPackets | None:
    """Return one call that answers for all, by how their frames travel; None: one module does not run all."""
    if len({getattr(finger.numbers.module, "library", id(finger.numbers.module)) for finger in fingers}) != 1:
        return None
    if all(finger.numbers.on_wire.state_id >= ROW_STRIDE for finger in fingers):
        return CompiledBatch(fingers, needs)
    is_plain = all(
        finger.numbers.on_wire.state_id < IDENTIFIERS and finger.numbers.on_wire.report_ids
        for finger in fingers
    )
    return CompiledPackets(fingers, needs) if is_plain else None
