"""From the slots to states: which message completes a finger, what is too old, what was never measured."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from vegrip.clock import NS
from vegrip.messages import FingertipState
from vegrip.transport.mapped.compiled import Build, Slots, compile_builder
from vegrip.transport.mapped.plan import FingerPlan, Slot


@dataclass(slots=True)
class _Gate:
    """A channel that counts as missing until one of its raw values has been another than zero."""

    slots: tuple[tuple[int, float], ...]  # and its value at zero

    def opens(self, s: Slots) -> bool:
        """Whether something is there that is not zero; what is not yet there tells nothing."""
        return any(s[number] != zero and not math.isnan(s[number]) for number, zero in self.slots)

    def shut(self, s: Slots) -> None:
        """Take its zeros for missing."""
        for number, _ in self.slots:
            s[number] = math.nan


class FingerStates:
    """Makes the states of one finger.

    Args:
        finger: its plan.
        slots: all slots of the hand.
        groups: which group of signals fills each slot.

    """

    def __init__(self, finger: FingerPlan, slots: Sequence[Slot], groups: Sequence[int]) -> None:
        self.name = finger.name
        self.build: Build = compile_builder(finger)
        self.always_zero: set[str] = set()
        self.count = -1  # the number of the last state, where no counter of theirs tells
        used = {number for plan in finger.channels.values() for number in plan.slots}
        self.triggers = frozenset(groups[number] for number in finger.trigger_slots)
        self._max_age = round(finger.max_age * NS)
        self._held: dict[int, tuple[int, ...]] = {}  # group -> its slots
        for group in {groups[number] for number in used} - (
            self.triggers if len(self.triggers) == 1 else set()
        ):
            self._held[group] = tuple(number for number in used if groups[number] == group)
        self._gates = {
            name: _Gate(tuple((number, slots[number].offset) for number in plan.slots))
            for name, plan in finger.channels.items()
            if plan.gated and plan.slots and name != "normal_force"
        }
        self.always_zero.update(self._gates)
        self.last = math.nan  # [N] the last normal force, for commands that rest on it

    def state(self, s: Slots, heard: Sequence[int], seq: int, stamp: int) -> FingertipState:
        """Return the state that is complete at ``stamp`` [ns]; changes slots that are missing to NaN."""
        for group, numbers in self._held.items():
            if stamp - heard[group] > self._max_age:
                for number in numbers:
                    s[number] = math.nan
        if self._gates:
            self._look(s)
        values = self.build(s)
        self.last = values[0]
        return FingertipState(stamp, self.name, seq, *values)

    def _look(self, s: Slots) -> None:
        for name in [name for name, gate in self._gates.items() if gate.opens(s)]:
            del self._gates[name]
            self.always_zero.discard(name)
        for gate in self._gates.values():
            gate.shut(s)
