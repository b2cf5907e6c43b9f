"""A node beside the one that grips, which is given what the hand senses before a fault makes it wrong.

It moves nothing. What it believes and would command in the end is what the grip would, had the fault taught
nothing: the same hand, the same loads and slips, and no wrong value.
"""

from collections.abc import Sequence

from vegrip.grip.parameters import GraspParameters
from vegrip.messages import FingertipState, ForceCommand
from vegrip.trials.candidates import make_node


class SoundNode:
    """Takes sound states; its commands are noted and go nowhere.

    Args:
        parameters: of the node that grips.
        fingers: of the hand.

    """

    def __init__(self, parameters: GraspParameters, fingers: Sequence[str]) -> None:
        self.node = make_node(parameters, tuple(fingers), "sound")
        self.node.configure()
        self.node.activate()
        self.course: list[tuple[float, ...]] = []  # [N] the commands of the fingers, at every look
        self._commands = dict.fromkeys(fingers, 0.0)

    def take(self, state: FingertipState, now: int) -> None:
        """Take a sound ``state`` at ``now`` [ns]."""
        for message in self.node.on_message(state, now):
            if isinstance(message, ForceCommand):
                self._commands[message.finger] = message.normal_force

    def look(self, now: int) -> None:
        """Let it watch for silence at ``now`` [ns], and note what it would command."""
        list(self.node.on_tick(now))
        self.course.append(tuple(self._commands.values()))
