"""The endpoint of a foreign hand on a CAN bus."""

import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

import can

from vegrip.clock import NS
from vegrip.messages import FingertipState, Message
from vegrip.transport.can_endpoint import MOST_FRAMES, CanEndpoint, Open
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.price import price

MASKS: Final = {False: 0x7FF, True: 0x1FFFFFFF}
NO_TRAFFIC_NS: Final = 2 * NS
"""[ns] after opening without one message of the map: the wrong bus, rate or database."""


class MappedCanEndpoint(CanEndpoint):
    """Frames of a foreign hand in and out.

    Besides the names of :class:`~vegrip.transport.can_endpoint.CanEndpoint` and of the codec, ``rejected``
    has ``no_traffic`` (nothing of the map has ever come), ``foreign`` (frames that the map does not read,
    told only with it) and ``command_held`` (frames that repeated a command whose lifetime was over).
    """

    def __init__(
        self, bus: can.BusABC, codec: MappedCodec, reopen: Open | None = None, timing: BitTiming | None = None
    ) -> None:
        super().__init__(bus, codec, reopen, timing, extended=True)
        self._mapped = codec
        self._opened = time.monotonic_ns()
        self._was_heard = False
        for identifier, data in codec.encoder.opening:
            self.send_frame(Frame(identifier, data))

    @property
    def sentences(self) -> Sequence[str]:
        """What the owner of the hand must know before it grips."""
        return price(self._mapped.plan)

    @property
    def rejected(self) -> Mapping[str, int]:
        """What went wrong so far, by name."""
        found = Counter(super().rejected)
        if not self._was_heard and time.monotonic_ns() - self._opened > NO_TRAFFIC_NS:
            found["no_traffic"] = 1
            found["foreign"] = self._mapped.foreign
        found["command_held"] = self._mapped.encoder.held
        return {name: count for name, count in found.items() if count}

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a state, then take what is there; repeat commands that are due."""
        deadline = time.monotonic() + timeout
        messages: list[FingertipState] = []
        arrivals: list[int] = []
        self._repeat()
        for _ in range(MOST_FRAMES):
            frame = self.next_frame(0.0 if messages else max(deadline - time.monotonic(), 0.0))
            if frame is None:
                break
            states = self._mapped.decode_all(frame)
            messages += states
            arrivals += [frame.stamp] * len(states)
        self._repeat()
        if messages and not self._was_heard:
            self._was_heard = True
            self._bring_only_its_own()
        self.arrivals = arrivals
        return messages

    def _repeat(self) -> None:
        for frame in self._mapped.due(time.monotonic_ns()):
            self.send_frame(frame)

    def _bring_only_its_own(self) -> None:
        """Have the controller leave out the frames of others, once it is known that this is the right bus."""
        self._filters = [
            {
                "can_id": one & ~EXTENDED,
                "can_mask": MASKS[bool(one & EXTENDED)],
                "extended": bool(one & EXTENDED),
            }
            for one in sorted(self._mapped.identifiers)
        ]
        self._filter()
