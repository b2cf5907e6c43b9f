"""The virtual hand on a bus: publishes what its fingertips sense, obeys force commands.

With a ``protocol`` it is no hand but its fingertips, each on a test bench (``virtual_bench.py``).
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from vegrip.nodes.virtual_bench import VirtualBenchNode

from vegrip.clock import NS
from vegrip.config import build as build_parameters
from vegrip.config import parameter
from vegrip.errors import ConfigError
from vegrip.grip.safety import reason_to_reject
from vegrip.host.realtime import HAND_PRIORITY
from vegrip.identification.simulate.bench import Benches
from vegrip.identification.simulate.protocol import read_protocol
from vegrip.messages import FingertipState, ForceCommand, Message, NodeStatus, Reason
from vegrip.runtime import NodeBase, NodeContext
from vegrip.virtual import HandSettings, VirtualHand, disturbances
from vegrip.virtual.hidden import make
from vegrip.virtual.settings import FingertipSettings

LONGEST_STEP = 0.05
"""More than this is never simulated in one tick [s]; a loop that late lets simulated time fall behind."""

PLAIN = HandSettings(tip=FingertipSettings().with_one_rate())
"""Its tips relax as the model of grasp_force does, which shows by a second rate that something is missing."""


@dataclass(frozen=True)
class Parameters:
    """What can be set of the node; the simulated hand is built anew when it is activated."""

    seed: int = parameter(0, low=0, high=2**31, doc="of the fingertips and their noise", live=False)
    disturbed: bool = parameter(True, doc="whether the object is disturbed", live=False)
    disturbance_seed: int = parameter(0, low=0, high=2**31, doc="of the disturbances", live=False)
    duration: float = parameter(0.0, unit="s", low=0.0, high=1e6, doc="end after this; 0 = never", live=False)
    hand: HandSettings = parameter(PLAIN, doc="what the hand is made of", live=False)
    protocol: str = parameter(
        "", doc="protocol file: each fingertip alone on a bench goes through it; empty = a hand", live=False
    )
    hidden: dict[str, Any] = parameter(
        {}, doc="on a bench: effects that the plain fingertip does not have, by name", live=False
    )


class AskedForce(NamedTuple):
    """What a finger was commanded last."""

    normal_force: float  # [N]
    reason: Reason
    expires: int  # [ns]


class VirtualHandNode(NodeBase):
    """Steps the hand by the time that has passed, and drops commands that have expired."""

    plant: Any = VirtualHand
    """What is stepped, or a stand-in with its ``fingers``, ``time``, ``asked``, ``epoch`` and ``advance``."""
    wakes_on_messages = False
    exclusive_messages: tuple[type[Message], ...] = (FingertipState,)
    received_messages: tuple[type[Message], ...] = (
        FingertipState,
        ForceCommand,
        NodeStatus,
    )  # also of rivals
    realtime_priority = HAND_PRIORITY
    _running = False

    def __init__(self, name: str, parameters: Parameters) -> None:
        super().__init__(name, parameters)
        self.refused: Counter[str] = Counter()
        self.hand = self.new_hand()
        self.commands: dict[str, AskedForce] = {}
        self._last: int | None = None

    @property
    def parameters(self) -> Parameters:
        """What was set; a running hand refuses to become another one."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: Parameters) -> None:
        if self._running:
            raise ConfigError(f"{self.name}: a running hand cannot be changed; deactivate the node first")
        self._parameters = parameters

    def configure(self) -> None:
        """Compile the simulation."""
        hand = self.new_hand()
        hand.advance(0.02, np.full(len(hand.fingers), math.nan))

    def activate(self) -> None:
        """Begin with an open hand around an object on its stand."""
        self.hand, self.commands, self._last, self.finished = self.new_hand(), {}, None, False
        self._running = True

    def deactivate(self) -> None:
        """Stop the simulation where it is."""
        self._running = False

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        """Keep the newest command of each finger; count those that cannot be obeyed."""
        if isinstance(message, ForceCommand):
            finger, expires = message.finger, message.expires
            objection = reason_to_reject(message.normal_force, message.stamp, expires, now)
            if finger not in self.hand.fingers:
                objection = "unknown finger"
            if objection:
                self.refused[objection] += 1
            else:
                self.commands[finger] = AskedForce(message.normal_force, message.reason, expires)
        return ()

    def on_tick(self, now: int) -> Iterable[Message]:
        """Simulate up to now; return the states sampled since the last tick."""
        elapsed = 0.0 if self._last is None else (now - self._last) / NS
        self._last = now
        hand, dt = self.hand, min(elapsed, LONGEST_STEP)
        hand.epoch = now - round((hand.asked + dt) * NS)
        asked = [self.commands.get(finger) for finger in hand.fingers]
        forces = [one.normal_force if one is not None and one.expires > now else math.nan for one in asked]
        samples = hand.advance(dt, np.array(forces))
        self.finished = 0.0 < self.parameters.duration <= hand.time
        return [state for sample in samples for state in sample.states(hand.fingers)]

    def new_hand(self) -> VirtualHand:
        """Return the hand of the parameters, at time zero."""
        p = self.parameters
        plate = p.hand.plate
        events = disturbances(p.disturbance_seed, p.duration or 3600.0, weight=plate.mass * plate.gravity)
        hand: VirtualHand = self.plant(p.hand, p.seed, events if p.disturbed else ())
        return hand


def build(settings: Mapping[str, Any], context: NodeContext) -> VirtualHandNode | VirtualBenchNode:
    """Make the node; the fingers of the hand are those of the bus."""
    where = f"{context.name} [parameters]"
    parameters = build_parameters(Parameters, settings, where)
    if parameters.protocol:
        protocol = read_protocol(Path(parameters.protocol))
        make(parameters.hidden)  # says what is wrong with a name or a key
        benches = Benches(context.fingers, parameters.hand, protocol, parameters.seed, parameters.hidden)
        return VirtualBenchNode(context.name, parameters, benches)
    if parameters.hidden:
        raise ConfigError(f"{where}: 'hidden' works on a bench only; give a 'protocol' too")
    if "fingers" not in settings.get("hand", {}):
        parameters = replace(parameters, hand=only(parameters.hand, context.fingers, where))
    if not set(parameters.hand.fingers) <= set(context.fingers):
        raise ConfigError(f"{where}: the bus knows {', '.join(context.fingers)} only")
    return VirtualHandNode(context.name, parameters)


def only(hand: HandSettings, fingers: tuple[str, ...], where: str) -> HandSettings:
    """Return ``hand`` with only those of its fingers that are in ``fingers``."""
    kept = [i for i, finger in enumerate(hand.fingers) if finger in fingers]
    if len(kept) < 2:
        raise ConfigError(f"{where}: give hand.fingers, hand.x and hand.y for {', '.join(fingers)}")
    return replace(
        hand,
        fingers=tuple(hand.fingers[i] for i in kept),
        x=tuple(hand.x[i] for i in kept),
        y=tuple(hand.y[i] for i in kept),
    )
