"""The loop of a trial with the node of the bus in it."""

from collections.abc import Iterable, Sequence

from vegrip.grip.node import GraspForce
from vegrip.hand_sample import HandSample
from vegrip.messages import ContactEstimate, ForceCommand, Message
from vegrip.trials.closed_loop import Loop
from vegrip.virtual import VirtualHand


class NodeLoop(Loop):
    """The loop with the node of the bus, which hears messages and answers by messages."""

    def __init__(self, hand: VirtualHand, node: GraspForce) -> None:
        node.configure()
        node.activate()
        self.node = node
        assert node.controller is not None  # noqa: S101 (it is configured)
        super().__init__(hand, node.controller)

    def answer(self, samples: Sequence[HandSample], now: int) -> None:
        for sample in samples:
            for state in sample.states(self.hand.fingers):
                self.take(self.node.on_message(state, now))
        self.take(self.node.on_tick(now))

    def take(self, answers: Iterable[Message]) -> None:
        """Obey the commands of the node; note what it tells of friction."""
        for message in answers:
            if isinstance(message, ForceCommand):
                self.commands[self.hand.fingers.index(message.finger)] = message.normal_force
            elif isinstance(message, ContactEstimate):
                self.course.believe(message, self.hand.time)
