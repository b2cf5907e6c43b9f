"""What a node is: pure code that answers messages and ticks; the runner does the rest."""

import importlib
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any, NamedTuple

from vegrip.clock import Clock
from vegrip.errors import UsageError, first_line, suggestion
from vegrip.messages import USUAL_FINGERS, Message
from vegrip.runtime.channel_watch import ChannelWatch
from vegrip.runtime.sender_watch import SenderWatch
from vegrip.runtime.statistics import LoopStatistics
from vegrip.runtime.telemetry import Telemetry

Answered = tuple[Any, Sequence[str]]
"""What the endpoint gets, and the fingers of which a report is due."""


class OfLoop(NamedTuple):
    """What the loop has beside node and link, for what answers states as bytes."""

    clock: Clock
    statistics: LoopStatistics
    senders: SenderWatch
    """Sees every state."""
    telemetry: Telemetry | None
    """Counts, and says what is to be shown."""
    channels: ChannelWatch | None
    """Sees the first states of every finger."""


class NodeBase:
    """A managed node that does nothing; override what is needed.

    It knows no socket, no clock and no file; time comes in as ``now`` [ns]. The runner calls it from one
    thread only, and ``on_message`` and ``on_tick`` only while the node is active. Exceptions that escape are
    counted, and the node is put on hold (:meth:`on_fault`) until it has been configured anew.
    """

    wakes_on_messages = True
    """Whether messages are to be answered as they come. A node that acts on its ticks only is not woken by
    messages; it finds them at its next tick, which saves a busy machine thousands of awakenings a second."""
    exclusive_messages: tuple[type[Message], ...] = ()
    """Kinds of message that only this node may send for its fingers. It is not activated where another node
    sends them, and counts them as ``also_sent`` later."""
    received_messages: tuple[type[Message], ...] = ()
    """Kinds of message that are of use to this node; the bus need not bring others. Empty: all are."""
    frame_path: Callable[[Any, OfLoop], Any] | None = None
    """Makes of an endpoint what answers states that come as bytes (:mod:`vegrip.grip.frame_path`)."""
    realtime_priority = 0
    """Of the loop while the node is active, where it is permitted (:mod:`vegrip.host.realtime`); 0: none."""
    lacking: Callable[[Collection[str]], list[str]] | None = None
    """What a user must know of a finger that measures such channels; None: nothing."""

    def __init__(self, name: str, parameters: Any = None) -> None:
        self.name = name
        self.parameters = parameters
        """A frozen dataclass made of :func:`vegrip.config.parameter` fields; the runner assigns a new one
        when a parameter changes. A setter that raises a :class:`~vegrip.errors.VegripError` refuses it."""
        self.rejected: Counter[str] = Counter()
        """What the node itself refused so far, counted by name; goes into NodeStatus."""
        self.finished = False
        """Set by a node that has nothing more to do (the end of a replay); the loop then ends."""
        self.failure = ""
        """What of its work is lost, in a sentence; its process then ends with exit code 4. Empty: nothing."""

    def describe_finger(self, finger: str, channels: Collection[str]) -> str:  # noqa: ARG002
        """Return what is said of a finger once it is known which channels it measures."""
        return ""

    def configure(self) -> None:
        """Build everything and compile what will run; may take seconds."""

    def activate(self) -> None:
        """Begin afresh; the first message follows."""

    def deactivate(self) -> None:
        """Stop acting; may be followed by ``activate``."""

    def cleanup(self) -> None:
        """Forget what ``configure`` built."""

    def on_message(self, message: Message, now: int) -> Iterable[Message]:  # noqa: ARG002
        """Answer one message with any number of messages.

        A ForceCommand is sent at once. What comes after the first one is taken when no other message waits
        to be answered: a lazy iterable thereby lets the commands of all fingers leave before any report is
        worked out.
        """
        return ()

    def on_tick(self, now: int) -> Iterable[Message]:  # noqa: ARG002
        """Do what is due by the clock; called once per tick period."""
        return ()

    def on_broken(self, finger: str, now: int) -> None:
        """Take note that states of ``finger`` have arrived that could not be understood."""

    def on_fault(self, now: int) -> Iterable[Message]:  # noqa: ARG002
        """Say what to send on this tick while the node is on hold after an exception.

        A commanding node repeats its last safe command or goes on with its fail-safe ramp. Must not rest on
        what has just failed.
        """
        return ()


PROGRAMS: dict[str, tuple[str, str]] = {
    # name: (module:function, one line of help)
    "grasp_force": (
        "vegrip.nodes.grasp_force:build",
        "fingertip states in, slip margins and force commands out",
    ),
    "virtual_hand": ("vegrip.nodes.virtual_hand:build", "five simulated soft fingertips that hold an object"),
    "record": ("vegrip.nodes.record:build", "write what is on the bus to a recording"),
    "replay": ("vegrip.nodes.replay:build", "send a recording as if it were a hand"),
    "monitor": ("vegrip.nodes.monitor:build", "live table of every finger"),
    "echo": (
        "vegrip.runtime.echo:build",
        "answer every state with a command at once; for latency measurements",
    ),
}
GROUP = "vegrip.programs"
"""Entry-point group under which other packages offer their programs."""


@dataclass(frozen=True)
class NodeContext:
    """What a program receives besides its settings."""

    name: str
    namespace: str = ""  # "" or like "left" or "lab/left"
    fingers: tuple[str, ...] = USUAL_FINGERS  # in the order of the bus
    tick_period: float = 0.002  # [s] of on_tick


Build = Callable[[Mapping[str, Any], NodeContext], NodeBase]


def find_program(name: str) -> Build:
    """Return the ``build`` function of a program: of the table, an entry point or ``module:function``."""
    target = _target(name)
    module, _, function = target.partition(":")
    try:
        build: Build = getattr(importlib.import_module(module), function)
    except Exception as error:  # noqa: BLE001 (whatever a program of another package raises when imported)
        reason = first_line(error)
        raise UsageError(f"the program {name!r} cannot be loaded from {target}: {reason}") from None
    if not callable(build):
        raise UsageError(f"the program {name!r} cannot be used: {target} is not a function")
    return build


def _target(name: str) -> str:
    if name in PROGRAMS:
        return PROGRAMS[name][0]
    for point in entry_points(group=GROUP):
        if point.name == name:
            return point.value
    if ":" in name:
        return name
    raise UsageError(
        f"there is no program {name!r}; {suggestion(name, PROGRAMS, 'give module:function, or one of')}"
    )
