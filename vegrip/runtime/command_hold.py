"""The last commands of a node, to be repeated when the node itself can no longer speak."""

from collections.abc import Iterable
from dataclasses import replace

from vegrip.messages import ForceCommand, Message, Reason


class CommandHold:
    """Remembers the last command of each finger: as many as there are fingers, never more than ``LIMIT``."""

    LIMIT = 64

    def __init__(self) -> None:
        self._last: dict[str, ForceCommand] = {}

    def remembered(self, message: Message) -> Message:
        """Keep ``message`` if it is a command and return it.

        Its number is raised if the finger has had a higher one while it was held: a receiver would take the
        command for a repeat.
        """
        if not isinstance(message, ForceCommand):
            return message
        last = self._last.get(message.finger)
        if last is not None and message.seq <= last.seq:
            message = replace(message, seq=last.seq + 1)
        if last is not None or len(self._last) < self.LIMIT:
            self._last[message.finger] = message
        return message

    def numbers(self) -> dict[str, int]:
        return {finger: command.seq for finger, command in self._last.items()}

    def take_over(self, standing: Iterable[ForceCommand]) -> None:
        """Know of commands that were sent without having been remembered."""
        for command in standing:
            last = self._last.get(command.finger)
            if (last is None and len(self._last) < self.LIMIT) or (
                last is not None and command.seq > last.seq
            ):
                self._last[command.finger] = command

    def commands(self, now: int) -> list[ForceCommand]:
        """Repeat each last command after half of its lifetime: same force, reason INPUT_HOLD."""
        renewed = [_renewed(last, now) for last in self._last.values() if _is_half_gone(last, now)]
        self._last |= {command.finger: command for command in renewed}
        return renewed


def _is_half_gone(command: ForceCommand, now: int) -> bool:
    return 2 * (now - command.stamp) >= command.expires - command.stamp


def _renewed(command: ForceCommand, now: int) -> ForceCommand:
    return replace(
        command,
        stamp=now,
        seq=command.seq + 1,
        adjustment=0.0,
        reason=Reason.INPUT_HOLD,
        expires=now + (command.expires - command.stamp),
    )
