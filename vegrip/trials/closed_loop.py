"""Hand and node in one loop of simulated time: no bus, no waiting, the same bits every time.

The node is the very :class:`~vegrip.grip.node.GraspForce` that runs on the bus. Its answers to the states
of one period act on the hand from the next period on, which is the delay that a bus would bring.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from vegrip.clock import NS
from vegrip.grip.node import GraspForce
from vegrip.messages import ContactEstimate, ForceCommand, Message
from vegrip.trials.candidates import make_node, parameters
from vegrip.trials.scenario import Scenario
from vegrip.types import Floats
from vegrip.virtual import VirtualHand
from vegrip.virtual.hand import TRUTHS

BELIEF_PERIOD_S = 0.05

FORCE, FORCE_X, FORCE_Y, TORQUE, FRICTION, RADIUS, K, UTILISATION = (
    TRUTHS.index(name)
    for name in (
        "normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "friction_coefficient",
        "contact_radius", "pressure_exponent", "utilisation",
    )
)  # fmt: skip


@dataclass
class Course:
    """What happened, sampled every :attr:`Loop.sampling`; columns in the order of ``fingers``."""

    fingers: tuple[str, ...]
    slips: int = 0
    dropped: bool = False
    time: list[float] = field(default_factory=list)  # [s]
    margin: list[list[float]] = field(default_factory=list)  # [-] true margins
    force: list[list[float]] = field(default_factory=list)  # [N] true normal forces
    command: list[list[float]] = field(default_factory=list)  # [N] NaN = none
    slipped: list[int] = field(default_factory=list)  # slips so far
    contact: list[list[tuple[float, ...]]] = field(default_factory=list)
    """True tangential force [N], torque [N m], friction, contact radius [m] and pressure exponent."""
    friction: list[tuple[float, float, float]] = field(default_factory=list)
    """What is believed of the first finger's friction: time [s], estimate [-], its std [-]."""

    def since(self, start: float) -> tuple[Floats, Floats, Floats]:
        """Return time (n,) [s], margins (n, fingers) [-] and forces (n, fingers) [N] from ``start`` on."""
        time = np.array(self.time)
        kept = time >= start
        return time[kept], np.array(self.margin)[kept], np.array(self.force)[kept]

    def sample(self, hand: VirtualHand, commands: Mapping[str, float]) -> None:
        """Add the truth of ``hand``, whose fingers are those of the course, as it is now."""
        rows = hand.truths().tolist()
        self.time.append(hand.time)
        self.slipped.append(hand.slips)
        self.margin.append([1.0 - row[UTILISATION] for row in rows])
        self.force.append([row[FORCE] for row in rows])
        self.contact.append(
            [
                (math.hypot(row[FORCE_X], row[FORCE_Y]), abs(row[TORQUE]), row[FRICTION], row[RADIUS], row[K])
                for row in rows
            ]
        )
        self.command.append([commands.get(finger, np.nan) for finger in self.fingers])

    def believe(self, contact: ContactEstimate, time: float) -> None:
        """Note what is believed of friction at ``time`` [s], every :data:`BELIEF_PERIOD_S`."""
        mu = contact.friction_coefficient
        if contact.finger != self.fingers[0] or not (contact.in_contact and mu.valid):
            return
        if not self.friction or time >= self.friction[-1][0] + BELIEF_PERIOD_S:
            self.friction.append((time, mu.value, mu.std))


class Loop:
    """Steps a hand and a node against each other.

    Args:
        hand: the virtual hand, with its disturbances.
        node: configured and activated here.
        period: [s] of the loop; commands act one period after the state that asked for them.
        sampling: [s] of the course.

    """

    def __init__(
        self, hand: VirtualHand, node: GraspForce, period: float = 0.002, sampling: float = 0.01
    ) -> None:
        self.hand, self.node, self.period, self.sampling = hand, node, period, sampling
        self.commands: dict[str, ForceCommand] = {}
        self.course = Course(hand.fingers)
        node.configure()
        node.activate()

    def run(self, duration: float) -> Course:
        """Run to ``duration`` [s] of simulated time, or until the object is lost."""
        while self.hand.time < duration - 0.5 * self.period and not self.hand.dropped:
            self.step()
        self.course.slips, self.course.dropped = self.hand.slips, self.hand.dropped
        return self.course

    def step(self) -> None:
        """Advance by one period."""
        now = round(self.hand.time * NS)
        valid = {finger: c.normal_force for finger, c in self.commands.items() if now <= c.expires}
        states = self.hand.step(self.period, valid)
        now = round(self.hand.time * NS)
        for state in states:
            self._take(self.node.on_message(state, now))
        self._take(self.node.on_tick(now))
        if self.hand.time >= len(self.course.time) * self.sampling:
            self.course.sample(self.hand, {f: c.normal_force for f, c in self.commands.items()})

    def _take(self, answers: Iterable[Message]) -> None:
        for message in answers:
            if isinstance(message, ForceCommand):
                self.commands[message.finger] = message
            elif isinstance(message, ContactEstimate):
                self.course.believe(message, self.hand.time)


def run_scenario(scenario: Scenario, name: str, knob: float) -> Course:
    """Run the controller ``name`` through ``scenario``."""
    hand = scenario.hand()
    settings = parameters(name, knob, scenario.settings.tip.friction)
    node = make_node(settings, hand.fingers)
    return Loop(hand, node).run(scenario.duration)
