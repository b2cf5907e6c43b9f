"""What every fault is: a small class that begins and ends in a scene."""

from typing import Protocol

from validation.faults.testbed import Scene


class Injection(Protocol):
    """A fault."""

    def begin(self, scene: Scene) -> None:
        """Let it happen from now on."""

    def end(self, scene: Scene) -> None:
        """Let it be over."""
