"""The drive of a map, simulated: it is made ready, presses as it is told, and says what it holds. Pure.

What it says of itself are ``[conditions]`` of its map: those that an entry of the opening brings about
(``unless``), and ``holding`` while a force is felt that it presses with.
"""

from collections.abc import Sequence

from vegrip.messages import FingertipState
from vegrip.transport.hands.virtual_device import CommandReader, VirtualDevice
from vegrip.transport.mapped.compiled import compile_raw
from vegrip.transport.mapped.plan import Plan
from vegrip.transport.maps.conditions import HOLDING, values_of
from vegrip.transport.maps.dialogue import Step, steps


class VirtualDrive(VirtualDevice):
    """A gripper that feels nothing; its object is where the fingers feel a force."""

    def __init__(self, plan: Plan, latency: float = 0.0) -> None:
        hand = plan.hand
        packets = [(f"{hand.path} [packets.{name}]", each) for name, each in hand.packets.items()]
        self._then = [step for where, each in packets for step in steps(each.then, 0, 0.0, None, where)]
        self._opened = [step for where, each in packets for step in steps(each.opened, 0, 0.0, None, where)]
        self._holds: set[str] = set()  # which conditions
        super().__init__(plan, 0, latency)

    def reset(self) -> None:
        """Begin as when it is switched on: it is not ready."""
        super().reset()
        self._holds.clear()
        self._say_conditions()

    def sense(self, state: FingertipState) -> None:
        is_held = state.normal_force > 0.0 and max(self.forces.values(), default=0.0) > 0.0
        self._holds = self._holds - {HOLDING} | ({HOLDING} if is_held else set())
        self._say_conditions()

    @property
    def is_ready(self) -> bool:
        """Whether all holds that its condition ``ready`` asks for."""
        ready = self._plan.hand.conditions.get(self._plan.hand.device.ready)
        wanted = {} if ready is None else values_of(ready)
        return all(self._raws.get(place, 0) in values for place, values in wanted.items())

    @property
    def _steps(self) -> Sequence[Step]:
        return (*super()._steps, *self._then, *self._opened)

    def _obey(self, step: Step, now: int) -> None:
        if step.unless:
            self._holds.add(step.unless)
            self._say_conditions()
        if step in self._opened:
            self._press(self._plan.fingers[0].name, 0.0)
        super()._obey(step, now)

    def _command(self, finger: str, reader: CommandReader, data: bytes) -> None:
        command, signals = self._plan.hand.fingers[finger].command, reader.message.signals
        if not self.is_ready or command is None:
            return
        motion = signals.get(command.motion)
        if motion is not None and compile_raw(reader.message, motion)(data) == command.opened:
            self._press(finger, 0.0)
        else:
            super()._command(finger, reader, data)

    def _say_conditions(self) -> None:
        maps = self._plan.hand.conditions
        held = [values_of(maps[name]) for name in self._holds if name in maps]
        self._raws = {place: max(values) for each in held for place, values in each.items()}
