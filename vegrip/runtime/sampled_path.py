"""The short way of a hand through the loop: samples go out and commands come in without a message for each.

A node that samples a whole hand (:class:`SamplesHand`), on a bus that takes that (:class:`TakesSamples`),
is asked for arrays at its ticks, and told of commands as plain values. While it is not active, and while the
telemetry shows what a finger sends or is sent, everything goes the way of messages.
"""

from collections.abc import Sequence
from typing import Final, Protocol, runtime_checkable

from vegrip.clock import Clock
from vegrip.hand_sample import HandSample
from vegrip.messages import FingertipState, ForceCommand, Lifecycle, Reason
from vegrip.runtime.managed import ManagedNode
from vegrip.runtime.statistics import LoopStatistics
from vegrip.runtime.telemetry import Direction, Telemetry
from vegrip.transport.codec.command_reader import ArrivedCommand, CommandReader
from vegrip.transport.state_sender import StateSender

PASSED: Final = ((FingertipState, Direction.OUT), (ForceCommand, Direction.IN))
"""What of a hand travels this way."""


@runtime_checkable
class SamplesHand(Protocol):
    """A node that senses all fingers of a hand at once."""

    @property
    def sampled_fingers(self) -> tuple[str, ...]:
        """The fingers in the order of :meth:`sample`."""

    def sample(self, now: int) -> Sequence[HandSample]:
        """Do what ``on_tick`` does; return the samples its states are made of."""

    def take_command(
        self, finger: str, normal_force: float, reason: Reason, stamp: int, expires: int, now: int
    ) -> None:
        """Do what ``on_message`` does with a command of ``normal_force`` [N]; times in [ns]."""


@runtime_checkable
class TakesSamples(Protocol):
    """An endpoint that may send samples and read commands without messages."""

    def state_sender(self, fingers: Sequence[str]) -> StateSender | None:
        """Return what sends samples of ``fingers``; None: nothing can here."""

    def command_reader(self) -> CommandReader | None:
        """Return what reads commands; None: nothing can here."""

    def take_commands(self, reader: CommandReader) -> Sequence[ArrivedCommand] | None:
        """Return the commands that have come; None: something else is there, to be received."""


class SampledPath:
    """Passes samples and commands of a hand; everything that it leaves alone travels as messages.

    Args:
        managed: the node.
        node: the same, without its lifecycle.
        endpoint: its link.
        clock: of the loop.
        statistics: of the loop.
        telemetry: counts, and says what is to be shown.

    """

    def __init__(
        self,
        managed: ManagedNode,
        node: SamplesHand,
        endpoint: TakesSamples,
        clock: Clock,
        statistics: LoopStatistics,
        telemetry: Telemetry | None,
    ) -> None:
        self._managed, self._node, self._endpoint = managed, node, endpoint
        self._clock, self._statistics, self._telemetry = clock, statistics, telemetry
        self._fingers: tuple[str, ...] = ()
        self._sender: StateSender | None = None
        self._reader: CommandReader | None = None

    def prepare(self) -> None:
        """Find out what can go this way, and compile it; the node has been configured."""
        self._fingers = self._node.sampled_fingers
        self._sender = self._endpoint.state_sender(self._fingers)
        self._reader = self._endpoint.command_reader()

    def tick(self, now: int) -> bool:
        """Let the node sample, and send that; return whether it was done."""
        sender = self._sender
        if sender is None or not self._is_open():
            return False
        try:
            samples = self._node.sample(now)
        except Exception as error:  # noqa: BLE001 (whatever a node raises must not end the loop)
            self._managed.fail(error, now)
            return True
        for sample in samples:
            self._statistics.states_sent += sender.send(sample)
            if self._telemetry is not None:
                for finger, lost in zip(self._fingers, sample.lost.tolist(), strict=True):
                    if not lost:
                        self._telemetry.count(FingertipState, finger, Direction.OUT)
        return True

    def take_commands(self) -> bool:
        """Let the node obey the commands that have come; return whether nothing else is there."""
        if self._reader is None or not self._is_open():
            return False
        commands = self._endpoint.take_commands(self._reader)
        if commands is None:
            return False
        for command in commands:
            self._obey(command)
        return True

    def _obey(self, command: ArrivedCommand) -> None:
        self._statistics.commands_received += 1
        now = self._clock.now()
        try:
            self._node.take_command(*command, now)
        except Exception as error:  # noqa: BLE001 (whatever a node raises must not end the loop)
            self._managed.fail(error, now)
        if self._telemetry is not None:
            self._telemetry.count(ForceCommand, command.finger, Direction.IN)

    def _is_open(self) -> bool:
        return self._managed.state is Lifecycle.ACTIVE and not self._is_shown()

    def _is_shown(self) -> bool:
        telemetry, fingers = self._telemetry, self._fingers
        if telemetry is None:
            return False
        return any(telemetry.wants(kind, f, direction) for kind, direction in PASSED for f in fingers)
