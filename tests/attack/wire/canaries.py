"""Nodes that are broken on purpose, each against one law: the attack must see it."""

from collections.abc import Mapping
from dataclasses import replace

from rig import Link, Rig

from vegrip.messages import ForceCommand, Message, Reason


class _Uncounted(Link):
    @property
    def rejected(self) -> Mapping[str, int]:
        return {}


class _Altered(Link):
    """Says something else while the input is bad."""

    factor = 1.0
    since = False  # and goes on with it
    seen = False

    def send(self, message: Message) -> None:
        if isinstance(message, ForceCommand):
            held = message.reason is Reason.INPUT_HOLD and self._clock.now() > self.begun + 2 * 10**9
            self.seen = self.seen or held
            if held or (self.since and self.seen):
                message = replace(message, normal_force=self.factor * message.normal_force)
        super().send(message)


class _Yielding(_Altered):
    factor = 0.9


class _Unbounded(_Altered):
    factor = 10.0


class _Resentful(_Altered):
    factor = 3.0
    since = True


class Uncounted(Rig):
    """Counts no refusal."""

    endpoint = _Uncounted


class Yielding(Rig):
    """Lets the grip down a little while the input is bad."""

    endpoint = _Yielding


class Unbounded(Rig):
    """Passes its largest force while the input is bad."""

    endpoint = _Unbounded


class Resentful(Rig):
    """Never forgives."""

    endpoint = _Resentful


CANARIES: dict[str, type[Rig]] = {
    "uncounted": Uncounted,
    "yielding": Yielding,
    "unbounded": Unbounded,
    "resentful": Resentful,
}
