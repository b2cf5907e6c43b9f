"""The last commands of a node, to be repeated when the node itself can no longer speak."""

from dataclasses import replace

from vegrip.messages import ForceCommand, Message, Reason


class Hold:
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

    def commands(self, now: int) -> list[ForceCommand]:
        """Return each last command again: same force, next number, fresh expiry, reason INPUT_HOLD."""
        for finger, last in self._last.items():
            self._last[finger] = replace(
                last,
                stamp=now,
                seq=last.seq + 1,
                adjustment=0.0,
                reason=Reason.INPUT_HOLD,
                expires=now + (last.expires - last.stamp),
            )
        return list(self._last.values())
