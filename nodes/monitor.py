"""A monitor on the bus: draws a live table of what it receives; sends nothing."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from vegrip.config import build as build_parameters
from vegrip.messages import Message
from vegrip.runtime import NodeBase, NodeContext
from vegrip.runtime.monitor.watch import Screen


@dataclass(frozen=True)
class Parameters:
    """It has no parameters."""


class MonitorNode(NodeBase):
    """Hands every message to the thread that draws."""

    wakes_on_messages = False

    def __init__(self, name: str, parameters: Parameters, fingers: tuple[str, ...]) -> None:
        super().__init__(name, parameters)
        self._fingers = fingers
        self._screen: Screen | None = None

    def activate(self) -> None:
        """Begin to draw."""
        self._screen = Screen(f"vegrip monitor: {self.name}", self._fingers)
        self._screen.open()

    def deactivate(self) -> None:
        """Draw no more."""
        if self._screen is not None:
            self._screen.close()
            self._screen = None

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        """Pass it on."""
        if self._screen is not None:
            self._screen.receive(message, now)
        return ()


def build(settings: Mapping[str, Any], context: NodeContext) -> MonitorNode:
    """Make the node."""
    parameters = build_parameters(Parameters, settings, f"{context.name} [parameters]")
    return MonitorNode(context.name, parameters, context.fingers)
