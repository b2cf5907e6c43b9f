"""The stage of every fault: a hand that holds an object, the grasp force node, and a recorder, on one bus.

Everything runs on a simulated clock with the loops and codecs of the real programs, so that a fault meets
what it would meet on a real bus, and meets it at the same instant in every run.
"""

import errno
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from vegrip.nodes.virtual_hand import AskedForce, Parameters, VirtualHandNode

from validation.faults.cosimulation import Cosimulation, Participant
from validation.faults.simulated_can import SimulatedCan, SimulatedEndpoint
from vegrip.clock import NS, SimulatedClock
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters
from vegrip.identification.recording.table_file import TableFile
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import Condition, FingertipState, Message
from vegrip.runtime import NodeBase
from vegrip.runtime.runner import LoopSettings
from vegrip.transport.codec import CanCodec
from vegrip.trials.candidates import demo_parameters, make_node
from vegrip.trials.closed_loop import GRASPS
from vegrip.virtual import HandSettings

STATE_RATE_HZ = 200.0
"""[Hz] of states. Less than the demonstration has, so that the whole table runs in a minute or two."""

SAMPLING = 0.01  # [s] of the truth
FLUSH_PERIOD_S = 0.1  # [s] between two writings of the recording

Falsify = Callable[[FingertipState], FingertipState]


class Hand(VirtualHandNode):
    """A virtual hand whose sensors can lie."""

    falsify: Falsify | None = None

    def on_tick(self, now: int) -> Iterable[Message]:
        """Simulate; return what the sensors say."""
        states = super().on_tick(now)
        if self.falsify is None:
            return states
        return [self.falsify(s) if isinstance(s, FingertipState) else s for s in states]


class _FickleFile(TableFile):
    """A table on a disk that may be full."""

    def __init__(self, plain: TableFile, writer: "FickleWriter") -> None:
        super().__init__(plain._path, plain._header)
        self._writer = writer

    def _write_some(self, data: bytes) -> int:
        if self._writer.full:
            raise OSError(errno.ENOSPC, "no space left on device")
        return super()._write_some(data)


class FickleWriter(RecordingWriter):
    """A recording on a disk that may be full."""

    full = False

    def _new(self, name: str, message: Message) -> TableFile:
        return _FickleFile(super()._new(name, message), self)


class Recorder(NodeBase):
    """Writes every message; what a program of its own does in a thread, this one does at its ticks."""

    answers = False

    def __init__(self, writer: FickleWriter) -> None:
        super().__init__("record")
        self.writer = writer
        self.received = 0

    def on_message(self, message: Message, now: int) -> Iterable[Message]:  # noqa: ARG002
        """Take the message."""
        self.received += 1
        self.writer.write(message)
        return ()

    def on_tick(self, now: int) -> Iterable[Message]:  # noqa: ARG002
        """Write what was taken."""
        self.writer.flush()
        return ()


@dataclass
class Course:
    """What happened, every ``SAMPLING``; forces in the order of the fingers."""

    time: list[float] = field(default_factory=list)  # [s]
    force: list[tuple[float, ...]] = field(default_factory=list)  # [N] true normal forces
    command: list[tuple[float, ...]] = field(default_factory=list)  # [N] the last of each finger
    condition: list[tuple[Condition, ...]] = field(default_factory=list)
    obeyed: list[bool] = field(default_factory=list)  # all fingers have a command that has not expired


class Scene:
    """A pinch of thumb and index (or a whole hand) that has closed and lifted its object.

    Args:
        grasp: which of :data:`~vegrip.trials.closed_loop.GRASPS`.
        writer: of a recording.
        sender_time: whether the node stamps states with the hand's clock.
        parameters: of the node.
        fd: whether the frames are of CAN FD.

    """

    def __init__(
        self,
        grasp: str = "pinch",
        writer: FickleWriter | None = None,
        *,
        sender_time: bool = False,
        parameters: GraspParameters | None = None,
        fd: bool = True,
    ) -> None:
        self.sender_time, self.fd = sender_time, fd
        self.clock = SimulatedClock()
        self.bus = SimulatedCan(self.clock)
        self.simulation = Cosimulation(self.bus, self.clock)
        self.settings: HandSettings = replace(
            GRASPS[grasp], sensor=replace(GRASPS[grasp].sensor, rate=STATE_RATE_HZ)
        )
        self.fingers: Sequence[str] = self.settings.fingers
        self.loop = LoopSettings(tick_period=1.0 / STATE_RATE_HZ)
        self.course = Course()
        self.grip = self.start_grip(parameters)
        self.hand_node = Hand("virtual_hand", replace(Parameters(), hand=self.settings, disturbed=False))
        self.hand = self.simulation.add(self.hand_node, self.endpoint(), self.loop)
        self.recorder = Recorder(writer) if writer is not None else None
        self.record: Participant | None = None
        if self.recorder is not None:
            self.record = self.simulation.add(
                self.recorder, self.endpoint(), LoopSettings(tick_period=FLUSH_PERIOD_S)
            )

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self.clock.now() / NS

    @property
    def node(self) -> GraspForce | None:
        """The node that grips, None while it is dead."""
        if self.grip not in self.simulation.participants:
            return None
        node = self.grip.node
        assert isinstance(node, GraspForce)  # noqa: S101 (start_grip made it)
        return node

    def endpoint(self, *, sender_time: bool = False) -> SimulatedEndpoint:
        """Return a new place on the bus."""
        return self.bus.endpoint(CanCodec(self.fingers, fd=self.fd, use_sender_time=sender_time))

    def start_grip(self, settings: GraspParameters | None = None) -> Participant:
        """Start the node that grips."""
        node = make_node(settings or demo_parameters(), tuple(self.fingers))
        self.grip = self.simulation.add(node, self.endpoint(sender_time=self.sender_time), self.loop)
        return self.grip

    def run_until(self, time: float) -> None:
        """Let everything happen up to ``time`` [s], and note the truth on the way."""
        while self.now < time - 0.5 * SAMPLING:
            self.simulation.run_until(self.now + SAMPLING)
            self._sample()

    def _sample(self) -> None:
        course, hand, commands = self.course, self.hand_node, self.hand_node.commands
        now = self.clock.now()
        course.time.append(self.now)
        course.force.append(tuple(hand.hand.truth(finger).normal_force for finger in self.fingers))
        course.command.append(tuple(_force(commands.get(finger)) for finger in self.fingers))
        course.obeyed.append(all(f in commands and commands[f].expires > now for f in self.fingers))
        course.condition.append(self._conditions())

    def _conditions(self) -> tuple[Condition, ...]:
        node = self.node
        if node is None:
            return (Condition.MISSING,) * len(self.fingers)
        return tuple(node.fingers[finger].condition for finger in self.fingers)


def _force(command: AskedForce | None) -> float:
    return 0.0 if command is None else command.normal_force
