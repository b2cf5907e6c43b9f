"""The frames of a packet of the virtual bus in one compiled call: states in, requests for commands out.

A state is answered exactly as :meth:`~vegrip.grip.finger.GraspFinger.step` answers its frame.
Only C does so; where it does not run, the frames of a packet are answered one by one.
"""

import ctypes
from collections.abc import Sequence
from typing import Any

from vegrip.grip.compiled import FingerKernelsC
from vegrip.grip.finger import GraspFinger
from vegrip.grip.packet_text import (
    ANSWER_BYTES,
    IDENTIFIERS,
    MOST_FINGERS,
    REQUEST_BYTES,
    RESULTS_FIRST,
    RESULTS_SIZE,
)
from vegrip.runtime.frame_path import PacketAnswer
from vegrip.transport.canbus.virtual_can import Taken
from vegrip.types import Floats


class CompiledPackets:
    """The compiled steps of all fingers, called for a packet.

    Args:
        fingers: in the order of the grasp, see :func:`can_take_packets`.
        needs: what every finger needs [N]; the array that the steps share.

    """

    def __init__(self, fingers: Sequence[GraspFinger], needs: Floats) -> None:
        self.fingers = tuple(fingers)
        self._names = [finger.name for finger in fingers]
        module = fingers[0].module
        kinds = ctypes.c_void_p * len(fingers)
        reals = kinds(*[finger.memory.f.ctypes.data for finger in fingers])
        wholes = kinds(*[finger.memory.t.ctypes.data for finger in fingers])
        numbers = (ctypes.c_uint8 * IDENTIFIERS)()
        for number, finger in enumerate(fingers, 1):
            numbers[finger.state_id] = number
        requests, results = (ctypes.c_uint8 * ANSWER_BYTES)(), (ctypes.c_int64 * RESULTS_SIZE)()
        report = (ctypes.c_uint8 * sum(REQUEST_BYTES))()
        self._requests, self._results, self._report = memoryview(requests), results, memoryview(report)
        self._step, self._pack_report = module.packet_step, module.packet_report
        self._given = [ctypes.addressof(reals), ctypes.addressof(wholes), needs.ctypes.data]
        self._given.append(ctypes.addressof(numbers))
        self._out = ctypes.addressof(requests), ctypes.addressof(results)
        self._report_at = ctypes.addressof(report)
        places = zip(self._names, reals, wholes, strict=True)
        self._memories: dict[str, Any] = {name: (f, t) for name, f, t in places}
        self._lives = reals, wholes, numbers, needs

    def step(self, packet: bytes, expected: int, now: int) -> PacketAnswer | None:
        """Answer the states at the beginning of a packet at ``now`` [ns]; None: it begins with none.

        Args:
            packet: of numbered deliveries.
            expected: number of its first one, if none was lost.
            now: [ns].

        """
        states = self._step(*self._given, packet, len(packet), expected, now, *self._out)
        if not states:
            return None
        results = self._results[: RESULTS_FIRST + 3 * states]
        size, lost, follows, end, busy, commands, length = results[:7]
        names = [self._names[number] for number in results[RESULTS_FIRST::3]]
        rows = list(zip(names, results[RESULTS_FIRST + 1 :: 3], results[RESULTS_FIRST + 2 :: 3], strict=True))
        taken = Taken(size, lost, follows, end, busy)
        return PacketAnswer(taken, commands, self._requests[:length], rows)

    def report(self, name: str, now: int) -> memoryview | None:
        """Return requests to send contact and slip margin of a finger, None where frames cannot tell them."""
        is_packed = self._pack_report(*self._memories[name], now, self._report_at)
        return self._report if is_packed else None


def can_take_packets(fingers: Sequence[GraspFinger]) -> bool:
    """Return whether one call can answer for all: C runs them, and every state is one frame with 11 bits."""
    modules = {finger.module.library for finger in fingers if isinstance(finger.module, FingerKernelsC)}
    in_c = all(isinstance(finger.module, FingerKernelsC) for finger in fingers)
    plain = all(f.state_id < IDENTIFIERS and f.report_ids for f in fingers)
    return in_c and len(modules) == 1 and plain and len(fingers) <= MOST_FINGERS
