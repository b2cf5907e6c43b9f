"""The real codec and node in simulated time, with the second hand at the other end of the wire."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from hand import Hand
from wires import FINGERS, WIRES, Command, Health, Heard, Refusals, Sent

from vegrip.clock import NS, SimulatedClock
from vegrip.grip.parameters import GraspParameters
from vegrip.messages import Message
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
from vegrip.transport.codec.frame_codec import Line
from vegrip.transport.endpoint import FRAMES, Endpoint, Intercept
from vegrip.trials.candidates import make_node

PERIOD = 0.005  # [s] between states
PHASE = 0.002  # [s] of the states after the ticks
STATUS = 0.1  # [s]

Fault = Callable[[int, int, dict[str, float]], Iterable[Sent]]
"""What goes out for a finger's state: finger, stamp [ns], values -> messages."""


@dataclass
class Course:
    """What the hand heard, step by step; of each finger."""

    force: list[list[float]] = field(default_factory=list)  # [N] last command
    obeyed: list[bool] = field(default_factory=list)  # no command has expired
    condition: list[list[int]] = field(default_factory=list)
    reason: list[list[int]] = field(default_factory=list)
    counts: list[dict[str, int]] = field(default_factory=list)
    broken: int = 0  # messages of the node that could not be read


class Link(Endpoint):
    """The endpoint of the node: bytes on one side, messages on the other."""

    def __init__(self, wire: str, clock: SimulatedClock) -> None:
        self.arrivals: Sequence[int] = ()
        self.outgoing: list[Sent] = []
        self.begun = clock.now()
        self._clock, self._inbox = clock, list[Sent]()
        self._can = CanCodec(FINGERS, fd=True) if wire == "can" else None
        self._codec = self._can or MsgpackCodec("left", FINGERS)
        self.broken = self._codec.broken

    @property
    def rejected(self) -> Mapping[str, int]:
        return Counter(self._codec.rejected)

    def deliver(self, sent: Sent) -> None:
        self._inbox.append(sent)

    def receive(self, timeout: float) -> Sequence[Message]:  # noqa: ARG002 (time is not its business)
        now = self._clock.now()
        found = [self._decoded(sent, now) for sent in self._inbox]
        self._inbox.clear()
        messages = [message for message in found if message is not None]
        self.arrivals = [now] * len(messages)
        return messages

    def send(self, message: Message) -> None:
        if isinstance(self._codec, CanCodec):
            self.outgoing += [Sent(f.arbitration_id, f.data) for f in self._codec.encode(message)]
        elif (encoded := self._codec.encode(message)) is not None:
            self.outgoing.append(Sent(*encoded))

    def close(self) -> None:
        pass

    def _decoded(self, sent: Sent, now: int) -> Message | None:
        if isinstance(self._codec, CanCodec):
            return self._codec.decode(Frame(int(sent.place), sent.data, fd=True, stamp=now))
        return self._codec.decode(str(sent.place), sent.data, now)


class FrameLink(Link):
    """The endpoint of a node on CAN, which may answer a frame by the compiled step before it is a message."""

    brings = FRAMES

    def __init__(self, wire: str, clock: SimulatedClock) -> None:
        super().__init__(wire, clock)
        self.intercept: Intercept | None = None

    def line(self, finger: str) -> Line | None:
        return self._can.line(finger) if self._can is not None else None

    def send_frame(self, frame: Frame) -> None:
        self.outgoing.append(Sent(frame.arbitration_id, frame.data))

    def send_frames(self, frames: Sequence[Frame]) -> None:
        for frame in frames:
            self.send_frame(frame)

    def _decoded(self, sent: Sent, now: int) -> Message | None:
        frame = Frame(int(sent.place), sent.data, fd=True, stamp=now)
        if self.intercept is not None and self.intercept(frame):
            return None
        return super()._decoded(sent, now)


class Rig:
    """A hand, a wire, a node; on CAN as it runs by default, with its step compiled."""

    endpoint: type[Link] | None = None  # another one: everything goes by messages

    def __init__(self, wire: str) -> None:
        self.wire, self.hand, self.course = WIRES[wire], Hand(), Course()
        self.clock, self.seq = SimulatedClock(), [0] * len(FINGERS)
        self.clock.sleep_until(7200 * NS)  # so that an hour before now is a time
        self.started = self.clock.now()
        self.link = (self.endpoint or (FrameLink if wire == "can" else Link))(wire, self.clock)
        node = make_node(GraspParameters(), FINGERS)
        self.limits = node.parameters.limits
        self.runner = Runner(
            node, self.link, self.clock, LoopSettings(tick_period=PERIOD, status_period=STATUS)
        )
        self.runner.start()
        self.steps = 0
        self.fault: Fault = self.sound
        self._commands: dict[int, tuple[Command, float]] = {}
        self._conditions = [3] * len(FINGERS)
        self._counts: dict[str, int] = {}

    @property
    def now(self) -> float:
        """Since the start [s]."""
        return self.steps * PERIOD

    def next_seq(self, finger: int) -> int:
        """Return the number of the next state, which is then used."""
        self.seq[finger] += 1
        return self.seq[finger] - 1

    def sound(self, finger: int, stamp: int, values: dict[str, float]) -> Iterable[Sent]:
        """Send the state as it is."""
        return (self.wire.state(finger, self.next_seq(finger), stamp, values),)

    def run_until(self, time: float) -> None:
        """Let everything happen up to ``time`` [s]."""
        while self.now < time - 0.5 * PERIOD:
            self.step()

    def step(self) -> None:
        """Tick, move, sense, answer, obey."""
        begin = self.started + round(self.now * NS)
        self.clock.sleep_until(begin)
        self.runner.step()
        self._hear()
        self.hand.advance(self.now, PERIOD)
        self.clock.sleep_until(begin + round(PHASE * NS))
        for finger in range(len(FINGERS)):
            for sent in self.fault(finger, self.clock.now(), self.hand.sensed(finger)):
                self.link.deliver(sent)
                self.runner.step()
                self._hear()
        self.steps += 1
        self._note()

    def _hear(self) -> None:
        for sent in self.link.outgoing:
            try:
                heard: Heard = self.wire.read(sent)
            except (ValueError, KeyError):
                self.course.broken += 1
                continue
            if isinstance(heard, Command):
                self._commands[heard.finger] = heard, self.now + heard.lifetime
                self.hand.obey(heard)
            elif isinstance(heard, Health):
                self._conditions[heard.finger] = heard.condition
            elif isinstance(heard, Refusals):
                self._counts = heard.counts
        self.link.outgoing.clear()

    def _note(self) -> None:
        course, known = self.course, [self._commands.get(f) for f in range(len(FINGERS))]
        course.force.append([math.nan if c is None else c[0].force for c in known])
        course.reason.append([-1 if c is None else c[0].reason for c in known])
        course.obeyed.append(all(c is not None and c[1] > self.now for c in known))
        course.condition.append(list(self._conditions))
        course.counts.append(self._counts)
