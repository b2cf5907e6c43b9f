"""What a node sees of the outside: messages come in, messages go out."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Protocol, Self, runtime_checkable

from vegrip.messages import Message
from vegrip.transport.codec import Frame
from vegrip.transport.sender_clock import ClockEstimate

Intercept = Callable[[Frame], bool]
"""Looks at a frame before it is decoded; whether it has dealt with it."""


class Endpoint(Protocol):
    """One place on a bus or network, closed by ``with``. Owned by one thread.

    Nothing here raises once it is open.

    Opening may raise :class:`~vegrip.errors.DeviceError`; afterwards whatever goes wrong is counted by
    name in :attr:`rejected`, and a lost bus is reopened by the endpoint itself.
    """

    arrivals: Sequence[int]
    """When each message of the last :meth:`receive` arrived here [ns], as closely as the bus can tell."""

    @property
    def rejected(self) -> Mapping[str, int]:
        """Everything that went wrong so far: refused, lost, unsent messages, counted by name."""

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a message, then take what is there without waiting more."""

    def send(self, message: Message) -> None:
        """Send now or drop and count; never waits."""

    def bus_load(self) -> float:
        """Return the share of the last second for which the bus was busy, NaN if not known."""

    def close(self) -> None:
        """Release the bus; further calls do nothing."""

    def __enter__(self) -> Self:
        """Return itself."""

    def __exit__(self, *error: object) -> None:
        """Close it."""


class ClosedByWith:
    """What makes a context manager of an endpoint: for classes that have ``close``."""

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close it."""
        self.close()

    def close(self) -> None:
        """Release the bus; further calls do nothing."""
        raise NotImplementedError


@runtime_checkable
class Timed(Protocol):
    """An endpoint that estimates the clock of those who send to it."""

    @property
    def clock(self) -> ClockEstimate | None:
        """The sender's clock against ours, None when it is not estimated."""


@runtime_checkable
class Inspected(Protocol):
    """An endpoint that tells whose states arrive broken."""

    @property
    def broken(self) -> Mapping[str, int]:
        """States that arrived and could not be understood, by finger; the same mapping every time."""


@runtime_checkable
class Selective(Protocol):
    """An endpoint that can leave aside what its node does not want."""

    def select(self, kinds: Collection[type[Message]]) -> None:
        """Bring only messages of ``kinds``, and what is not understood."""


@runtime_checkable
class Gathering(Protocol):
    """An endpoint that keeps what is sent together until it is told that this is all."""

    def flush(self) -> None:
        """Send what was kept."""

    def put_off(self, message: Message) -> None:
        """Send ``message`` behind what is sent next, or at the next :meth:`flush`."""


@runtime_checkable
class TakesAll(Protocol):
    """An endpoint that sends several messages in less time than one by one."""

    def send_all(self, messages: Sequence[Message]) -> None:
        """Send ``messages``."""


@runtime_checkable
class Guarded(Protocol):
    """An endpoint whose connections may be refused, by others or by itself."""

    @property
    def in_trouble(self) -> bool:
        """Whether a connection that we need is refused at present; the counts say why."""


@runtime_checkable
class Zeroed(Protocol):
    """An endpoint of devices that can take their own zeros."""

    def zero(self) -> bool:
        """Have them take their zeros; whether there is a command for that."""


@runtime_checkable
class Priced(Protocol):
    """An endpoint of a hand that does not tell all that ours does."""

    @property
    def sentences(self) -> Sequence[str]:
        """What is missing and what that costs, logged when a node starts."""
