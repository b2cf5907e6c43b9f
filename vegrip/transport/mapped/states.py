"""States of the fingers of a foreign hand: which message completes one, what is too old, what is missing."""

import math
from collections import Counter
from collections.abc import Sequence

from vegrip.clock import NS
from vegrip.messages import FingertipState
from vegrip.transport.codec.sequence import Sequence as Counted
from vegrip.transport.mapped.compiled import Build, Slots, compile_builder
from vegrip.transport.mapped.plan import NOT_YET, FingerPlan, Plan, Slot


class FingerStates:
    """The states of one finger.

    Args:
        finger: its plan.
        slots: all slots of the hand.
        groups: which group of signals fills each slot.

    """

    def __init__(self, finger: FingerPlan, slots: Sequence[Slot], groups: Sequence[int]) -> None:
        self.name = finger.name
        self.build: Build = compile_builder(finger)
        self._count = -1  # the number of the last state, where no counter of theirs tells
        self.last = math.nan  # [N] the last normal force, for commands that rest on it
        used = {number for plan in finger.channels.values() for number in plan.slots}
        self.triggers = frozenset(groups[number] for number in finger.trigger_slots)
        self._max_age = round(finger.max_age * NS)
        always_new = self.triggers if len(self.triggers) == 1 else frozenset()
        self._held = {  # group -> its slots
            group: tuple(number for number in used if groups[number] == group)
            for group in {groups[number] for number in used} - always_new
        }
        self._always_zero = {  # channel -> its slots, and their values at zero
            name: tuple((number, slots[number].offset) for number in plan.slots)
            for name, plan in finger.channels.items()
            if plan.gated and plan.slots and name != "normal_force"
        }

    @property
    def always_zero(self) -> set[str]:
        """The channels that have been nothing but zero so far, and therefore missing."""
        return set(self._always_zero)

    def state(self, s: Slots, heard: Sequence[int], seq: int | None, stamp: int) -> FingertipState:
        """Return the state that is complete at ``stamp`` [ns]; changes slots that are missing to NaN."""
        if seq is None:
            seq = self._count = self._count + 1
        for group, numbers in self._held.items():
            if stamp - heard[group] > self._max_age:
                for number in numbers:
                    s[number] = math.nan
        if self._always_zero:
            self._leave_out_zeros(s)
        values = self.build(s)
        self.last = values[0]
        return FingertipState(stamp, self.name, seq, *values)

    def _leave_out_zeros(self, s: Slots) -> None:
        for name, zeros in list(self._always_zero.items()):
            if any(s[number] != zero and not math.isnan(s[number]) for number, zero in zeros):
                del self._always_zero[name]
                continue
            for number, _ in zeros:
                s[number] = math.nan


class ForeignHand:
    """The last values of a foreign hand, and counts of what was refused.

    Args:
        plan: of the hand.
        groups: which group of signals fills each slot; signals of a group come together.

    """

    def __init__(self, plan: Plan, groups: Sequence[int]) -> None:
        self.plan = plan
        self.rejected: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.clipped: Counter[str] = Counter()
        self._slots: list[float] = [math.nan] * len(plan.slots)
        self._heard = [NOT_YET] * (max(groups, default=-1) + 1)
        self._states = {finger.name: FingerStates(finger, plan.slots, groups) for finger in plan.fingers}
        self._sequences: list[Counted] = []

    @property
    def lost(self) -> int:
        """Messages that never arrived, where they have a counter."""
        return sum(sequence.lost for sequence in self._sequences)

    @property
    def always_zero(self) -> dict[str, set[str]]:
        """The channels that have been nothing but zero so far, and therefore missing, by finger."""
        return {name: states.always_zero for name, states in self._states.items()}

    def reset(self) -> None:
        """Forget all counters: what comes next begins new streams (a replay that starts over)."""
        for sequence in self._sequences:
            sequence.last = -1

    def _refuse(self, name: str, owners: Sequence[str] = ()) -> list[FingertipState]:
        self.rejected[name] += 1
        for owner in owners:
            self.broken[owner] += 1
        return []

    def _sequence(self, modulus: int) -> Counted:
        self._sequences.append(Counted(modulus))
        return self._sequences[-1]

    def _owners(self, message: str) -> tuple[str, ...]:
        """Return the fingers with a channel in ``message``."""
        own = {slot.number for slot in self.plan.slots if slot.message == message}
        return tuple(
            finger.name
            for finger in self.plan.fingers
            if any(own.intersection(channel.slots) for channel in finger.channels.values())
        )

    def _completed_by(self, message: str) -> tuple[FingerStates, ...]:
        return tuple(self._states[finger.name] for finger in self.plan.fingers if finger.trigger == message)

    def _state_of(self, finger: str) -> tuple[float, float]:
        """Return the last normal force of ``finger`` [N] and its position in the unit of their signal."""
        slot = self.plan.feedback.get(finger)
        return self._states[finger].last, math.nan if slot is None else self._slots[slot]
