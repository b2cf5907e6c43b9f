"""What the short ways through the loop have in common: the node that answers, its link, what the loop has."""

from collections.abc import Iterable, Mapping
from typing import Generic, NamedTuple, Protocol, TypeVar

from vegrip.clock import Clock
from vegrip.runtime.channel_watch import ChannelWatch
from vegrip.runtime.sender_watch import SenderWatch
from vegrip.runtime.statistics import LoopStatistics
from vegrip.runtime.telemetry import Telemetry


class Numbering(Protocol):
    """A node whose commands are numbered."""

    def number_commands_from(self, numbers: Mapping[str, int]) -> None:
        """Give every next command a number above these."""


class OfLoop(NamedTuple):
    """What the loop has beside node and link."""

    clock: Clock
    statistics: LoopStatistics
    senders: SenderWatch
    """Sees every state."""
    telemetry: Telemetry | None
    """Counts, and says what is to be shown."""
    channels: ChannelWatch | None
    """Sees the first states of every finger."""


Node = TypeVar("Node", bound=Numbering)
Endpoint = TypeVar("Endpoint")


class ShortWay(Generic[Node, Endpoint]):
    """A way of states past the messages: from ``endpoint`` to ``node`` and back."""

    def __init__(self, node: Node, endpoint: Endpoint, loop: OfLoop) -> None:
        self.frames = 0
        """States that went this way."""
        self._knows_all = False
        self.node, self._endpoint = node, endpoint
        self._clock, self._statistics, self._senders, self._telemetry, self._channels = loop

    def knows_all(self, fingers: Iterable[str]) -> bool:
        """Return whether the channels of all ``fingers`` are known, as they are from then on."""
        if not self._knows_all:
            channels = self._channels
            self._knows_all = channels is None or all(map(channels.knows, fingers))
        return self._knows_all

    def renumber(self, sent: Mapping[str, int]) -> None:
        """Go on with the numbers of commands that were sent in the node's place."""
        self.node.number_commands_from(sent)
