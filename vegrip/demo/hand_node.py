"""The virtual hand of the demonstration: the node on the bus, and beside the bus what it alone knows."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from vegrip.messages import Message
from vegrip.nodes.virtual_hand import Parameters, VirtualHandNode
from vegrip.trials.closed_loop import Course
from vegrip.trials.scenario import Scenario
from vegrip.virtual import VirtualHand

SAMPLING = 0.01  # [s] of the truth


@dataclass(frozen=True, slots=True)
class HandNews:
    """How the object is doing."""

    time: float  # [s] simulated
    slips: int
    dropped: bool
    acting: tuple[str, ...]  # names of the disturbances that act now


class DemoHand(VirtualHandNode):
    """A virtual hand that goes through a scenario and keeps the truth of it."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.course = Course(scenario.settings.fingers)
        settings = replace(
            Parameters(), hand=scenario.settings, seed=scenario.seed, duration=scenario.duration
        )
        super().__init__("virtual_hand", settings)

    def configure(self) -> None:
        super().configure()
        self.new_hand().truths()

    def on_tick(self, now: int) -> Iterable[Message]:
        """Simulate up to now, and note the truth."""
        states = super().on_tick(now)
        if self.hand.time >= len(self.course.time) * SAMPLING and not self.hand.dropped:
            asked = (self.commands.get(finger) for finger in self.hand.fingers)
            forces = [math.nan if one is None else one.normal_force for one in asked]
            self.course.sample(self.hand, forces)
        self.finished = self.finished or self.hand.dropped
        return states

    def news(self) -> HandNews:
        time = self.hand.time
        acting = tuple(
            type(event).__name__
            for event in self.hand.events
            if event.start < time < event.start + event.duration
        )
        return HandNews(time, self.hand.slips, self.hand.dropped, acting)

    def rest(self) -> Any:
        self.course.slips, self.course.dropped = self.hand.slips, self.hand.dropped
        return self.course

    def new_hand(self) -> VirtualHand:
        return self.scenario.hand()
