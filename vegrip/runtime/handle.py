"""A running node as a transport may handle it that has network management of its own (CANopen)."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from vegrip.errors import VegripError
from vegrip.messages import Lifecycle
from vegrip.runtime.lifecycle import describe_parameters, route, with_value
from vegrip.runtime.runner import Runner

Refused = Callable[[str], None]


class NodeHandle:
    """What may be done to a node, by the thread of its loop, while it waits for messages."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner

    @property
    def state(self) -> Lifecycle:
        return self._runner.state

    @property
    def on_hold(self) -> bool:
        return self._runner.managed.on_hold

    def request(self, *targets: Lifecycle, refused: Refused) -> None:
        """Go through the states ``targets`` as soon as the loop has served what it has."""

        def change() -> None:
            try:
                for target in targets:
                    for step in route(self.state, target):
                        self._runner.change(step)
            except VegripError as error:
                refused(str(error))

        self._runner.inbox.put(change)

    def parameters(self) -> dict[str, Any]:
        return {
            row["name"]: row["value"] for row in describe_parameters(self._runner.managed.node.parameters)
        }

    def set_parameter(self, name: str, value: Any) -> None:
        node = self._runner.managed.node
        running = self.state in (Lifecycle.INACTIVE, Lifecycle.ACTIVE)
        node.parameters = with_value(node.parameters, name, value, running, self._runner.full_name)


@runtime_checkable
class Supervised(Protocol):
    """An endpoint that manages the node by what the bus says."""

    def supervise(self, node: NodeHandle, *, autostart: bool) -> None:
        """Begin; activate the node when the checks pass, if ``autostart``."""
