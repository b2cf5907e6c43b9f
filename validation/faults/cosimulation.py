"""Nodes with their real loops on one simulated bus and clock: repeatable, and faster than real time.

From event to event: the end of a frame, a tick, a status. A node answers a frame at the instant at which the
frame ends; how long its computer takes is not simulated, except by :meth:`Cosimulation.starve`.
"""

from dataclasses import dataclass

from validation.faults.simulated_can import SimulatedCan, SimulatedEndpoint
from vegrip.clock import NS, SimulatedClock
from vegrip.runtime.node import NodeBase
from vegrip.runtime.runner import LoopSettings, Runner


@dataclass
class Participant:
    """A node, its loop and its place on the bus."""

    runner: Runner
    endpoint: SimulatedEndpoint
    asleep_until: int = 0  # [ns] its computer is busy with something else

    @property
    def node(self) -> NodeBase:
        return self.runner.managed.node

    @property
    def due(self) -> int:
        """When its loop has something to do [ns]."""
        return max(self.runner.due, self.asleep_until)

    def ready(self, now: int) -> bool:
        if now < self.asleep_until:
            return False
        return now >= self.runner.due or (self.node.wakes_on_messages and self.endpoint.has_waiting)


class Cosimulation:
    """The nodes in the order in which they were added, on :attr:`bus` and :attr:`clock`."""

    def __init__(self, bus: SimulatedCan, clock: SimulatedClock) -> None:
        self.bus, self.clock = bus, clock
        self.participants: list[Participant] = []

    def add(
        self, node: NodeBase, endpoint: SimulatedEndpoint, loop: LoopSettings | None = None
    ) -> Participant:
        """Start ``node`` with ``endpoint``; its loop begins now."""
        participant = Participant(Runner(node, endpoint, self.clock, loop), endpoint)
        participant.runner.start()
        self.participants.append(participant)
        return participant

    def kill(self, participant: Participant) -> None:
        """End a node at once, as ``kill -9`` does."""
        self.participants.remove(participant)
        participant.endpoint.close()

    def starve(self, participant: Participant, duration: float) -> None:
        """Give the computer of a node to others for ``duration`` [s]: its loop stands still."""
        participant.asleep_until = self.clock.now() + round(duration * NS)

    def run_until(self, time: float) -> None:
        """Let everything happen up to ``time`` [s]."""
        end = round(time * NS)
        while (event := self._next_event()) <= end:
            self.clock.sleep_until(event)
            self.bus.advance()
            for participant in tuple(self.participants):
                if participant.ready(self.clock.now()):
                    participant.runner.step()
        self.clock.sleep_until(end)
        self.bus.advance()

    def _next_event(self) -> int:
        now = self.clock.now()
        times = [participant.due for participant in self.participants]
        times += [
            max(now, p.asleep_until)
            for p in self.participants
            if p.endpoint.has_waiting and p.node.wakes_on_messages
        ]
        bus = self.bus.next_event()
        return min([*times, bus] if bus is not None else times)
