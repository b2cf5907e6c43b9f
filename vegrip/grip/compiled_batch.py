"""All fingers of a hand in one compiled call: a batch of states in, the batch of their commands out.

A row is answered exactly as :meth:`~vegrip.grip.finger.GraspFinger.step` answers its frame, in
the order of the rows. Where C runs the step, the rows are gone through in C; else here.
"""

import ctypes
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from vegrip.grip.batch_text import COMMAND_ROW, COMMANDED, CONTACT_ROW, MARGIN_ROW
from vegrip.grip.compiled import FingerKernelsC
from vegrip.grip.finger import LEFT_ALONE, GraspFinger
from vegrip.transport.codec.batch_codec import FIRST_ROW, ROW_ID, ROW_STRIDE
from vegrip.types import Floats

LONGEST_STATE: Final = 64  # [bytes]


class CompiledBatch:
    """The compiled steps of all fingers, called at once.

    Args:
        fingers: whose frames travel as rows, see :func:`can_batch`.
        needs: what every finger needs [N]; the array that the steps share.
        state_bytes: length of the frame of a state.

    """

    def __init__(self, fingers: Sequence[GraspFinger], needs: Floats, state_bytes: int) -> None:
        self.fingers = tuple(fingers)
        self.commands = bytearray(FIRST_ROW + len(fingers) * COMMAND_ROW)
        """The batch of the last commands; its head is still to be written."""
        self.contacts = bytearray(FIRST_ROW + len(fingers) * 2 * CONTACT_ROW)
        """The batch of the last contacts, likewise."""
        self.margins = bytearray(FIRST_ROW + len(fingers) * MARGIN_ROW)
        """The batch of the last slip margins, likewise."""
        self._rows = {finger.state_id: finger for finger in fingers}
        self._state_row = ROW_ID.size + state_bytes
        self._frame = np.zeros(LONGEST_STATE, dtype=np.uint8)
        numbers = [number_of(finger.state_id) for finger in fingers]
        self._done = bytearray(2**8)
        self._numbers = {finger.name: number_of(finger.state_id) for finger in fingers}
        self._named = {finger.name: finger for finger in fingers}
        self._told = bytearray(2**8)
        self._identifiers = b"", b""  # of the rows that came last, low and high bytes,
        self._names: list[str] = []  # and whose they are
        self._call: Any = None
        self._report: Any = None
        if isinstance(fingers[0].module, FingerKernelsC):
            self._bind(fingers[0].module, needs, max(numbers) + 1)

    def step(self, payload: bytes, rows: int, arrival: int, now: int) -> tuple[bytearray, int]:
        """Answer the ``rows`` of a batch that is whole, which arrived at ``arrival`` at ``now`` [ns].

        Returns:
            What was done with each row, in bits (more items than rows), and how many commands there are.

        """
        if self._call is not None:
            return self._done, self._call(payload, rows, arrival, now)
        return self._done, self._step_by_step(payload, rows, arrival, now)

    def report(self, names: Sequence[str], now: int) -> list[str]:
        """Pack contacts and slip margins of fingers by their names; return whose were told, in that order."""
        if self._report is None:
            return self._report_one_by_one(names, now)
        self._report(bytes([self._numbers[name] for name in names]), len(names), now)
        return [name for name, told in zip(names, self._told, strict=False) if told]

    def names_in(self, payload: bytes, rows: int) -> Sequence[str]:
        """Return whose states the rows are, "" for another one's; mostly they come in the same order."""
        end = FIRST_ROW + rows * self._state_row
        low, high = (slice(FIRST_ROW + byte, end, self._state_row) for byte in range(ROW_ID.size))
        identifiers = payload[low], payload[high]
        if identifiers != self._identifiers:
            fingers = [self.finger_of(payload, row) for row in range(rows)]
            self._names = ["" if finger is None else finger.name for finger in fingers]
            self._identifiers = identifiers
        return self._names

    def finger_of(self, payload: bytes, row: int) -> GraspFinger | None:
        """Return whose state a row is, None for another one's."""
        (identifier,) = ROW_ID.unpack_from(payload, FIRST_ROW + row * self._state_row)
        return self._rows.get(identifier)

    def _step_by_step(self, payload: bytes, rows: int, arrival: int, now: int) -> int:
        commands, length = 0, self._state_row - ROW_ID.size
        for row in range(rows):
            finger, self._done[row] = self.finger_of(payload, row), LEFT_ALONE
            if finger is None:
                continue
            start = FIRST_ROW + row * self._state_row + ROW_ID.size
            self._frame[:length] = np.frombuffer(payload, np.uint8, length, start)
            self._done[row] = finger.step(self._frame, length, arrival, now)
            if self._done[row] & COMMANDED:
                at = FIRST_ROW + commands * COMMAND_ROW
                ROW_ID.pack_into(self.commands, at, finger.command_id)
                self.commands[at + ROW_ID.size : at + COMMAND_ROW] = finger.answer_frame.tobytes()
                commands += 1
        return commands

    def _report_one_by_one(self, names: Sequence[str], now: int) -> list[str]:
        told: list[str] = []
        for name in names:
            finger = self._named[name]
            if not finger.tell(now):
                continue
            rows = [
                ROW_ID.pack(identifier) + frame.tobytes()
                for identifier, frame in zip(finger.report_ids, finger.report_frames, strict=True)
            ]
            at, margin = FIRST_ROW + len(told) * 2 * CONTACT_ROW, FIRST_ROW + len(told) * MARGIN_ROW
            self.contacts[at : at + 2 * CONTACT_ROW] = rows[0] + rows[1]
            self.margins[margin : margin + MARGIN_ROW] = rows[2]
            told.append(name)
        return told

    def _bind(self, module: FingerKernelsC, needs: Floats, places: int) -> None:
        """Prepare the calls of C with all that stays the same."""
        kinds = ctypes.c_void_p * places
        reals, wholes = kinds(), kinds()
        for finger in self.fingers:
            number = number_of(finger.state_id)
            reals[number], wholes[number] = finger.memory.f.ctypes.data, finger.memory.t.ctypes.data
        first = self.fingers[0]
        kept = [ctypes.addressof(reals), ctypes.addressof(wholes), needs.ctypes.data, places]
        kept += [self._state_row, first.state_id % ROW_STRIDE, COMMAND_ROW, first.command_id % ROW_STRIDE]
        answers, done = _address(self.commands, FIRST_ROW), _address(self._done)
        step = module.batch_step
        packed = [_address(self.contacts, FIRST_ROW), _address(self.margins, FIRST_ROW), _address(self._told)]

        def call(payload: bytes, rows: int, arrival: int, now: int) -> int:
            commands: int = step(*kept, payload, rows, arrival, now, answers, done)
            return commands

        def report(numbers: bytes, count: int, now: int) -> None:
            module.batch_report(kept[0], kept[1], numbers, count, now, *packed)

        self._call, self._report, self._lives = call, report, (reals, wholes, needs)


def _address(data: bytearray, at: int = 0) -> int:
    """Return where ``data`` lies, which may not become longer from then on."""
    return ctypes.addressof(ctypes.c_uint8.from_buffer(data, at))


def number_of(identifier: int) -> int:
    """Return the number of the finger whose row has this Data ID."""
    return identifier // ROW_STRIDE - 1


def can_batch(fingers: Sequence[GraspFinger]) -> bool:
    """Return whether one call can answer for all: their frames travel as rows, and one module runs them."""
    modules = {getattr(finger.module, "library", id(finger.module)) for finger in fingers}
    return len(modules) == 1 and all(finger.state_id >= ROW_STRIDE for finger in fingers)
