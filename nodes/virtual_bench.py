"""Fingertips of the virtual hand on test benches, on a bus: they go through a protocol, and obey nothing."""

from collections.abc import Iterable
from typing import Any

from vegrip.clock import NS
from vegrip.host.realtime import HAND_PRIORITY
from vegrip.identification.simulate.bench import Benches
from vegrip.messages import FingertipState, Message
from vegrip.runtime import NodeBase


class VirtualBenchNode(NodeBase):
    """Publishes what the fingertips on ``benches`` feel as time goes by; ends with the protocol."""

    wakes_on_messages = False
    exclusive_messages: tuple[type[Message], ...] = (FingertipState,)
    realtime_priority = HAND_PRIORITY

    def __init__(self, name: str, parameters: Any, benches: Benches) -> None:
        super().__init__(name, parameters)
        self.benches = benches
        self._last: int | None = None

    def configure(self) -> None:
        """Work out what will be felt."""
        self.benches.prepare()

    def activate(self) -> None:
        """Begin the protocol."""
        self.benches.rewind()
        self._last, self.finished = None, False

    def on_tick(self, now: int) -> Iterable[Message]:
        """Return the states up to now."""
        elapsed = 0 if self._last is None else now - self._last
        self._last = now
        self.benches.epoch = now - round((self.benches.time + elapsed / NS) * NS)
        states = self.benches.step(elapsed / NS)
        self.finished = self.benches.finished
        return states
