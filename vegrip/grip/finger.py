"""One finger of a grasp: what it does with a state, and what it commands.

States come as messages (:meth:`GraspFinger.answer`) or as frames (:meth:`GraspFinger.step`). Each passes the
watchdog, the estimate of the contact, the demand, the policy, fail-safe and limits; the text of all that
is :mod:`vegrip.grip.kernels`, one stage a file, and :class:`~vegrip.grip.finger_step.FingerStep` has the
numbers on which it works. What is reported is :class:`~vegrip.grip.finger_reports.FingerReports`.

An estimator, a policy or a share of the grasp in Python takes part between the halves of the step. That costs
what the Python costs, and some 20 us; frames are then decoded to messages.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from vegrip import messages
from vegrip.clock import NS
from vegrip.estimator.estimator import quantile
from vegrip.estimator.memory import FingerMemory
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger_reports import FingerReports
from vegrip.grip.finger_step import FingerStep, Place, as_whole
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.layout import MARGIN, write_choice, write_rules
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.policy import GripPolicy
from vegrip.grip.settings import ControlSettings, make_policy, policy_settings
from vegrip.grip.wires import LEFT_ALONE
from vegrip.transport.codec.frame_codec import Line
from vegrip.types import Floats

RENEWAL: Final = 0.25
"""Part of its lifetime after which a command is renewed: three of them may get lost."""
NO_QUICKEST: Final = 1 << 62
"""[ns] No state has come yet, see :mod:`vegrip.grip.kernels.watchdog`."""

DEGRADED: Final = int(messages.Condition.DEGRADED)
REASONS: Final = tuple(messages.Reason(number) for number in range(len(messages.Reason)))

FRESH: Final[Mapping[str, float]] = {
    "GRIP_HELD": math.nan, "GRIP_ENVELOPE": math.nan, "GRIP_ELAPSED": -math.inf, "GRIP_PRESENT": -math.inf,
    "GRIP_MEDIAN": -math.inf, "GRIP_PROVEN": math.inf, "TRANSFER_FORCE": math.nan, "TRANSFER_LOAD": math.nan,
    "TRANSFER_ARM": math.nan, "TURN_REASON": int(messages.Reason.HOLD), "TURN_REPORTED_CONDITION": -1,
    "TAKEN_BOUND": math.nan,
}  # fmt: skip
"""What of a memory is not zero before the first state, besides :data:`UNHEARD`."""
UNRECEIVED: Final[Mapping[str, float]] = {
    "INPUT_CONDITION": int(messages.Condition.MISSING), "INPUT_QUICKEST": NO_QUICKEST,
    "WATCH_LEVEL": math.nan,
}  # fmt: skip
"""The same of the input, as it is before the first state."""
UNKNOWN_AT_FIRST: Final = ("REPEATED", "REPEATED_FORCE", "NOISE_LAST", "CONFIRMED")
TIMES: Final = (
    "INPUT_RECEIVED", "INPUT_CORRUPT", "INPUT_STILL_SINCE", "INPUT_FORCE_STILL_SINCE", "INPUT_TRAVEL_SINCE",
    "TURN_TRANSFER_SINCE", "TURN_COMMANDED", "TURN_ASKED", "TURN_USED",
)  # fmt: skip
"""[ns] What is kept of the times at which states came and commands left, besides REPEAT_SINCE."""
INPUT_SECTIONS: Final = (
    *("INPUT", "WATCH", "FAULTS"),
    *("NOISE_CHANGE", "REPEAT_LIMIT", "REPEATS", "TURNS", "REPEAT_RUN", "REPEAT_SINCE", "NOISE_COUNT"),
)  # fmt: skip


class GraspFinger:
    """A finger: its step, its reports, and a policy in Python where it has one.

    Args:
        name: of the finger.
        estimator: of its contact; a :class:`vegrip.ContactEstimator` is computed by the step.
        settings: how the grasp is controlled.
        place: in the grasp.
        shared: what the fingers of the grasp share.
        phase: see :class:`~vegrip.grip.finger_reports.FingerReports`.
        line: how its frames travel; None: its states come as messages.
        mode: what runs the step, see :func:`~vegrip.grip.compiled.finger_module`.
        alone: whether nothing but the step works on it, as in firmware: no history is kept.

    """

    def __init__(
        self,
        name: str,
        estimator: Estimator,
        settings: ControlSettings,
        place: Place,
        shared: GraspMemory,
        *,
        phase: float = 0.0,
        line: Line | None = None,
        mode: str = "",
        alone: bool = False,
    ) -> None:
        self.name = name
        self.numbers = FingerStep(name, estimator, place, shared, line=line, mode=mode, alone=alone)
        self.policy: GripPolicy | None = None if settings.is_built_in else make_policy(settings)
        """A policy in Python; None: the step has it."""
        self._forgotten = 0  # how often the policy was asked to forget
        self._put_first({**FRESH, **UNRECEIVED})
        self._settings = settings
        self.reports = FingerReports(self.numbers, settings, phase)
        self.apply(settings)

    @property
    def estimator(self) -> Estimator:
        return self.numbers.estimator

    @property
    def memory(self) -> FingerMemory:
        return self.numbers.memory

    def apply(self, settings: ControlSettings) -> None:
        """Go on with other settings; what has been learned and what is held stay."""
        self.numbers.leave_line()  # it says how long a command lives
        memory, self._settings = self.memory, settings
        write_rules(memory, settings)
        memory["RULE_QUANTILE"] = quantile(settings.grip.probability)
        self._lifetime = round(settings.limits.lifetime * NS)  # [ns] of a command
        memory["SETUP_RENEWAL"] = math.ceil(RENEWAL * settings.limits.lifetime * NS)
        if self.policy is not None:
            self.policy.settings = policy_settings(settings)
        if not self.numbers.alone:
            write_choice(memory, settings)
            policy = self.policy
            memory["CHOICE_ASKS"] = settings.policy == MARGIN if policy is None else policy.uses_least_force
            memory["CHOICE_SHARE"] = bool(settings.contacts)
        self.is_whole = not self.why_split
        """Whether one call answers a state: no estimator, policy or share in Python takes part."""
        self.reports.apply(settings)

    # states in

    @property
    def why_split(self) -> str:
        """What takes part in Python, in words; empty: nothing."""
        reasons = {
            "the estimator is of another make": self.numbers.own is not None,
            f"the policy is {self._settings.policy}": self.policy is not None,
            "the places of the contacts are given": bool(self._settings.contacts),
        }
        return next((reason for reason, holds in reasons.items() if holds), "")

    def answer(self, state: messages.FingertipState, now: int) -> int:
        """Answer one state that arrived at ``now`` [ns]; return what was done, in bits.

        One that holds something else than numbers is left alone, and counts as broken.
        """
        taken = self.numbers.put(state)
        if taken is None:
            self.note_broken(now)
            return LEFT_ALONE
        seq, stamp = taken
        return self.numbers.answer(seq, stamp, now)

    def answer_values(self, values: Floats, seq: int, stamp: int, now: int) -> None:
        """Answer a state of which no message was made, as :meth:`answer`."""
        self.numbers.put_values(values)
        self.numbers.answer(seq, stamp, now)

    def sense(self, state: messages.FingertipState, now: int) -> bool | None:
        """Take in one state and find what the finger needs; return whether the state is accepted.

        None: it holds something else than numbers, and counts as broken.
        """
        taken = self.numbers.put(state)
        if taken is None:
            self.note_broken(now)
            return None
        seq, stamp = taken
        if self.numbers.own is None and self.policy is None:
            return bool(self.numbers.sense(seq, stamp, now))
        believed = bool(self.numbers.judge(seq, stamp, now))
        if believed and self.numbers.own is not None:
            grip = self._settings.grip
            wanted = grip.wanted_margin, grip.probability
            self.numbers.own.take(state, wanted, asks=bool(self.memory["CHOICE_ASKS"]))
        elif believed:
            self.numbers.take(now)
        if self.numbers.bound(now) and self.policy is not None:
            self._ask(self.policy)
        self.numbers.need(now)
        self._let_forget()
        return believed

    def settle(self, now: int, share: float = math.nan) -> int:
        """Command the finger's share of the grasp, once it has begun; return what was done, in bits.

        ``share`` [N] counts where the places of the contacts are given.
        """
        if self._settings.contacts:
            self.memory["OWN_SHARE"] = share
        return self.numbers.settle(now)

    def watch(self, now: int) -> bool:
        """Look for silence, and hold the last command through it; return whether a command is due."""
        is_due = bool(self.numbers.watch(now))
        self._let_forget()
        return is_due

    def hold_last(self, now: int) -> bool:
        """Hold the last command through a fault of the node; return whether a command is due."""
        is_due = bool(self.numbers.hold_last(now))
        self._let_forget()
        return is_due

    def restart(self) -> None:
        """Forget input and contact but keep the command: the node is back from a fault of its own."""
        memory = self.memory
        self.estimator.reset()
        for section in INPUT_SECTIONS:
            memory.section(section)[:] = 0
        self._put_first(UNRECEIVED)
        memory["TURN_SEEN"] = memory["TURN_HAS_MARGIN"] = 0

    def move_times(self, by: int) -> None:
        """Go on by a clock that was set by ``by`` [ns]."""
        memory = self.memory
        for key in TIMES:
            memory[key] = as_whole(memory[key] + by)
        since = memory.section("REPEAT_SINCE")
        since[:] = [as_whole(one + by) for one in since.tolist()]
        memory["INPUT_QUICKEST"] = NO_QUICKEST

    def _put_first(self, values: Mapping[str, float]) -> None:
        for key, value in values.items():
            self.memory[key] = value
        for section in UNKNOWN_AT_FIRST:
            self.memory.section(section)[:] = math.nan

    def note_broken(self, now: int) -> None:
        """Note that a state of this finger arrived broken at ``now`` [ns]."""
        self.memory["INPUT_CORRUPT"], self.memory["INPUT_IS_CORRUPT"] = now, 1

    def step(self, frame: np.ndarray, length: int, arrival: int, now: int) -> int:
        """Answer a frame; what is done is returned in bits, and LEFT_ALONE means nothing at all."""
        return self.numbers.answer_bytes(frame, length, arrival, now)

    def take_line(self) -> bool:
        """Return whether frames can be taken, and let the memory count them from then on."""
        return self.is_whole and self.numbers.take_line(self._settings.limits.lifetime)

    def _ask(self, policy: GripPolicy) -> None:
        self._let_forget()
        memory = self.memory
        least, load, torque, bound = memory.section("DEMAND").tolist()
        touches, slips, is_trusted, _ = memory.section("NEED").tolist()
        demand = Demand(least, load, torque, bound, bool(touches), bool(slips), bool(is_trusted))
        force, reason = policy.wanted(memory["OWN_BASE"], demand, memory["OWN_STEP"])
        memory["OWN_FORCE"], memory["CHOICE_REASON"] = force, reason

    def _let_forget(self) -> None:
        if self.policy is not None and self.memory["CHOICE_FORGOTTEN"] != self._forgotten:
            self._forgotten = self.memory["CHOICE_FORGOTTEN"]
            self.policy.reset()

    # what it commands

    @property
    def started(self) -> bool:
        return bool(self.memory["TURN_STARTED"])

    @property
    def held(self) -> float:
        """The force commanded last [N]; NaN before the start."""
        return float(self.memory["GRIP_HELD"])

    @property
    def need(self) -> float:
        """What the finger needs [N], as the grasp knows it; NaN without a command."""
        return self.numbers.shared[self.numbers.place.number]

    def command(self) -> messages.ForceCommand:
        """Return the last command."""
        numbers = self.numbers
        whole, real = numbers.wholes, numbers.reals
        (commanded, seq, reason), (held, adjustment) = numbers.turn, numbers.given
        stamp = whole[commanded]
        values = (
            stamp, self.name, whole[seq], real[held], real[adjustment], REASONS[whole[reason]],
            stamp + self._lifetime,
        )  # fmt: skip
        made: messages.ForceCommand = messages.make_row(messages.ForceCommand, values)
        return made

    def standing_command(self) -> messages.ForceCommand:
        """Return the last command; its adjustment is over, and its reason that of the need."""
        return replace(self.command(), adjustment=0.0, reason=REASONS[self.memory["TURN_REASON"]])

    def number_from(self, seq: int) -> None:
        self.memory["TURN_SEQ"] = max(self.memory["TURN_SEQ"], seq)

    # its input

    @property
    def condition(self) -> messages.Condition:
        return self.reports.condition

    @property
    def faults(self) -> dict[messages.Condition, int]:
        counts = zip(messages.Condition, self.memory.section("FAULTS").tolist(), strict=True)
        return {condition: count for condition, count in counts if count}

    def is_quiet(self, now: int) -> bool:
        """Return whether a tick has nothing to do: no silence, and no command to renew."""
        numbers = self.numbers
        whole, (is_received, received, started, commanded, renewal, condition) = numbers.wholes, numbers.quiet
        is_known = whole[is_received] and now - whole[received] <= numbers.reals[numbers.time_out_at]
        is_fresh = not whole[started] or now - whole[commanded] < whole[renewal]
        return bool(is_known and is_fresh and whole[condition] <= DEGRADED)
