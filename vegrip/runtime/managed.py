"""A node under its lifecycle: transitions are checked, exceptions counted, and a fault puts it on hold."""

import contextlib
import logging
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from vegrip.clock import NS
from vegrip.messages import ForceCommand, Lifecycle, Message, Reason
from vegrip.runtime.lifecycle import state_after
from vegrip.runtime.node import NodeBase


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


Answer = TypeVar("Answer", Message, Message | None)
"""None: what the node has sent by itself."""

FIRST_RETRY = 1 * NS  # [ns] from a fault to the first attempt to activate again
LAST_RETRY = 30 * NS  # [ns] it doubles up to this


class ManagedNode:
    """Calls a node as its state allows. Only :meth:`change` raises.

    After an exception the node is inactive and on hold: at each tick its ``on_fault`` speaks for it. Should
    that be silent or fail too, its last commands are repeated before they expire. It is activated again
    after a back-off that doubles.
    """

    def __init__(self, node: NodeBase, logger: logging.Logger) -> None:
        self.node = node
        self.state = Lifecycle.UNCONFIGURED
        self.on_hold = False
        self.faults: Counter[str] = Counter()
        self._hold = CommandHold()
        self._retry_at = 0  # [ns]
        self._back_off = FIRST_RETRY
        self.logger = logger

    def change(self, transition: str) -> None:
        """Make one transition; the node's own method is called first, and when it raises nothing changes."""
        target = state_after(self.state, transition)
        self._note_standing()
        if transition == "shutdown":
            self._wind_down()
        else:
            getattr(self.node, transition)()
        self.state = target
        self.on_hold = False

    def on_message(self, message: Message, now: int) -> Iterator[Message]:
        return self.answers(lambda: self.node.on_message(message, now), now)

    def answers(self, ask: Callable[[], Iterable[Answer]], now: int) -> Iterator[Answer]:
        """Let an active node answer what ``ask`` asks it, as far as the answers are taken."""
        if not self._is_active():
            return
        try:
            for answer in ask():
                yield self._hold.remembered(answer) if isinstance(answer, ForceCommand) else answer
                if not self._is_active():  # it may have been changed before the next answer is taken
                    return
        except Exception as error:  # noqa: BLE001 (whatever a node raises must not end the loop)
            self._fault(error, now)

    def on_broken(self, finger: str, now: int) -> None:
        """Let an active node know that states of ``finger`` arrive broken; not every node asks for it."""
        take = getattr(self.node, "on_broken", None)
        if take is None or not self._is_active():
            return
        try:
            take(finger, now)
        except Exception as error:  # noqa: BLE001 (whatever a node raises must not end the loop)
            self._fault(error, now)

    def on_tick(self, now: int) -> Sequence[Message]:
        """Let an active node act, or hold the last safe commands of a failed one."""
        if self.on_hold:
            return self._held(now)
        if not self._is_active():
            return ()
        return self._remembered(self._guarded(self.node.on_tick, now, now))

    def _is_active(self) -> bool:
        return self.state is Lifecycle.ACTIVE

    def _remembered(self, messages: Sequence[Message]) -> Sequence[Message]:
        return [self._hold.remembered(message) for message in messages]

    def _guarded(
        self, call: Callable[..., Iterable[Message]], now: int, *arguments: Any
    ) -> Sequence[Message]:
        try:
            return tuple(call(*arguments))
        except Exception as error:  # noqa: BLE001 (whatever a node raises must not end the loop)
            self._fault(error, now)
            return ()

    def _fault(self, error: Exception, now: int) -> None:
        self.faults[f"fault {type(error).__name__}"] += 1
        self.logger.error("on hold after %s: %s", type(error).__name__, error, exc_info=error)
        if not self.on_hold:
            self.on_hold = True
            self.state = Lifecycle.INACTIVE
            self._retry_at = now + self._back_off
            self._note_standing()

    def fail(self, error: Exception, now: int) -> None:
        self._fault(error, now)

    def numbers_sent(self) -> dict[str, int]:
        return self._hold.numbers()

    def _note_standing(self) -> None:
        standing = getattr(self.node, "standing_commands", None)
        if standing is not None:
            with contextlib.suppress(Exception):  # whatever is wrong, the commands that are known are held
                self._hold.take_over(standing())

    def _held(self, now: int) -> Sequence[Message]:
        if now >= self._retry_at and self._recovered(now):
            return ()
        own = self._remembered(self._guarded(self.node.on_fault, now, now))
        return [*own, *self._hold.commands(now)]

    def _recovered(self, now: int) -> bool:
        self._back_off = min(2 * self._back_off, LAST_RETRY)
        self._retry_at = now + self._back_off
        try:
            self.node.deactivate()
            self.node.activate()
        except Exception as error:  # noqa: BLE001 (the node stays on hold)
            self._fault(error, now)
            return False
        self.on_hold, self.state = False, Lifecycle.ACTIVE
        self.logger.warning("active again")
        return True

    def _wind_down(self) -> None:
        steps = {Lifecycle.ACTIVE: ("deactivate", "cleanup"), Lifecycle.INACTIVE: ("cleanup",)}
        for step in steps.get(self.state, ()):
            try:
                getattr(self.node, step)()
            except Exception as error:
                self.faults[f"fault {type(error).__name__}"] += 1
                self.logger.error("%s failed: %s", step, error, exc_info=error)
