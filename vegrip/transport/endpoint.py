"""What a node sees of the outside: messages come in, messages go out."""

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence, Set
from types import MappingProxyType
from typing import Final, Protocol, Self

from vegrip.messages import Message
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.sender_clock import ClockEstimate


class Lossy(Protocol):
    """What both codecs count."""

    clipped: Counter[str]

    @property
    def lost(self) -> int:
        """Messages that never arrived."""


def losses(codec: Lossy) -> dict[str, int]:
    """Return the counts that are not zero: ``lost`` on the way in, ``clipped`` quantities on the way out."""
    counts = {"lost": codec.lost, "clipped": codec.clipped.total()}
    return {name: count for name, count in counts.items() if count}


Intercept = Callable[[Frame], bool | None]
"""Looks at a frame before it is decoded; whether it has dealt with it."""

FRAMES: Final = "frames"
PACKETS: Final = "packets"
BATCHES: Final = "batches"
"""How states come as bytes: in single frames, in packets of them too, in batches."""
PART_GONE: Final = "lost_"
PART_BACK: Final = "back_"
"""How counts begin which say that a part has gone, and that it has come back, which is no fault."""
ADVICE: Final = ("more_than_needed", "uneven_jaws")
"""Counts of what works, and might be otherwise."""
NONE_BROKEN: Final[Mapping[str, int]] = MappingProxyType({})


class Endpoint(ABC):
    """One place on a bus or network, closed by ``with``. Owned by one thread.

    Opening may raise :class:`~vegrip.errors.DeviceError`; afterwards nothing raises: whatever goes wrong is
    counted by name in :attr:`rejected`, and a lost bus is reopened by the endpoint itself.
    """

    arrivals: Sequence[int] = ()
    """When each message of the last :meth:`receive` arrived here [ns], as closely as the bus shows."""
    broken: Mapping[str, int] = NONE_BROKEN
    """States that arrived and could not be understood, by finger; the same mapping every time."""
    heard: int = 0
    """When a device last said anything that is understood, a state or not [ns]; 0: never, or not known."""
    brings: str = ""
    """How states of our own layout come as bytes, for who answers them so; else all come as messages."""
    hints: Mapping[str, str] = MappingProxyType({})
    """What counts of :attr:`rejected` that only this endpoint has mean, and what to do, in a sentence."""

    @property
    @abstractmethod
    def rejected(self) -> Mapping[str, int]:
        """Everything that went wrong so far: refused, lost, unsent messages, counted by name."""

    @abstractmethod
    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a message, then take what is there without waiting more."""

    @abstractmethod
    def send(self, message: Message) -> None:
        """Send now or drop and count; never waits."""

    @abstractmethod
    def close(self) -> None:
        """Release the bus; further calls do nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    # what most have no use for

    def bus_load(self) -> float:
        """Return the share of the last second for which the bus was busy, NaN if not known."""
        return math.nan

    @property
    def clock(self) -> ClockEstimate | None:
        """The sender's clock against ours, None when it is not estimated."""
        return None

    @property
    def in_trouble(self) -> bool:
        """Whether a connection that we need is refused at present; the counts say why."""
        return False

    @property
    def sentences(self) -> Sequence[str]:
        """What a hand does not send that ours does and what that costs, logged when a node starts."""
        return ()

    @property
    def conditions(self) -> Set[str]:
        """What devices say of themselves now, by the names of ``[conditions]`` of their maps."""
        return frozenset()

    @property
    def obeys(self) -> bool:
        """Whether devices that have to be ready for a command are, as far as they say."""
        return True

    @property
    def device_faults(self) -> Set[tuple[str, str]]:
        """Which of :attr:`conditions` are faults, each with the device that says it."""
        return frozenset()

    @property
    def descriptors(self) -> Sequence[int]:
        """What becomes readable when something comes; none: it must be asked again and again."""
        return ()

    def line(self, finger: str) -> Line | None:  # noqa: ARG002
        """Return how states and commands of ``finger`` travel as bytes; None: not by single frames."""
        return None

    def select(self, kinds: Collection[type[Message]]) -> None:  # noqa: B027
        """Bring only messages of ``kinds``, and what is not understood, where that saves anything."""

    def send_all(self, messages: Sequence[Message]) -> None:
        for message in messages:
            self.send(message)

    def put_off(self, message: Message) -> None:
        """Send ``message`` behind what is sent next, or at the next :meth:`flush`, where that saves time."""
        self.send(message)

    def flush(self) -> None:  # noqa: B027
        """Send what was kept to be sent together."""

    def zero(self) -> bool:
        """Have devices take their own zeros; whether there is a command for that."""
        return False
