"""A finger of the node that runs compiled: frames of states in, frames of commands out, one call each.

The objects of the finger (:class:`~vegrip.grip.finger.GraspFinger` and its parts) and the memory of the
compiled step hold the same numbers, and only one of them at a time is in force: :meth:`CompiledFinger.lend`
hands everything to the memory, :meth:`CompiledFinger.take_back` to the objects. What is not in the step (a
frame that is refused, a sender's clock that starts anew, parameters, silence) is done by the objects.
"""

from dataclasses import dataclass
from types import FunctionType
from typing import Final

import numpy as np

from vegrip.clock import NS
from vegrip.estimator import ContactEstimator
from vegrip.grip.batch_text import COMMAND_BYTES, REPORT_BYTES
from vegrip.grip.compiled import FingerKernels, FingerKernelsC, bound_step, compile_now, finger_module
from vegrip.grip.controller import GripController
from vegrip.grip.finger import RECENT_STATES, GraspFinger
from vegrip.grip.grasp_friction import GraspFriction
from vegrip.grip.layout import HISTORY_CHANNELS, FingerLayout
from vegrip.grip.memory import FingerMemory
from vegrip.grip.policies.margin_grip import MarginGrip
from vegrip.grip.recent_states import KeptStates
from vegrip.grip.settings import ControlSettings
from vegrip.grip.wires import WIRES
from vegrip.messages import Condition, FingertipState, ForceCommand, Reason
from vegrip.runtime.telemetry import Unmade
from vegrip.transport.codec.line import CLASSIC, FingerLine
from vegrip.types import Floats

LEFT_ALONE: Final = 0
"""The compiled step did not take the frame, and changed nothing."""
REPORT: Final = 4
"""Bit of a step after which something is due to be told."""

DEGRADED: Final = int(Condition.DEGRADED)
PART_BYTES: Final = 8
"""Of a classic frame."""
REASONS: Final = tuple(Reason(number) for number in range(len(Reason)))
FETCHED_STATES: Final = 64
"""States that are fetched from the memory at once, unless all are wanted."""
MOST_LATE: Final = RECENT_STATES // 2
"""Samples an estimator may go back: a rewind needs the states, and half of the history is fetched at once."""


@dataclass(frozen=True)
class Place:
    """Which finger of how many; ``thumb`` is the number of the one the others press against, or -1."""

    number: int
    fingers: int
    thumb: int


def why_not_compiled(finger: GraspFinger, settings: ControlSettings) -> str:
    """Return what this finger is told to do that the compiled step does not; "" when it does everything.

    The step has the margin grip alone, and shares between thumb and fingers but not by the places of the
    ``contacts``: with these, and for any other policy or estimator, the objects answer.
    """
    estimator = finger.estimator
    reasons = {
        f"the policy is {settings.policy}": not isinstance(finger.controller.policy, MarginGrip),
        "the places of the contacts are given": bool(settings.contacts),
        "the estimator is of another make": not isinstance(estimator, ContactEstimator),
        f"the estimator goes back by more than {MOST_LATE} states": isinstance(estimator, ContactEstimator)
        and estimator.settings.late > MOST_LATE,
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


class CompiledFinger:
    """One finger and its memory.

    Args:
        finger: the objects; :func:`why_not_compiled` has nothing against them.
        line: of its frames.
        place: in the grasp.
        shared: what the fingers of the grasp share, first what every one needs [N], NaN without a command.
        mode: what runs the step, see :func:`~vegrip.grip.compiled.finger_module`.
        alone: whether nothing but the step works on it, as in firmware: no history is kept, and a clock that
            starts anew is followed.

    """

    def __init__(
        self,
        finger: GraspFinger,
        line: FingerLine,
        place: Place,
        shared: Floats,
        mode: str = "",
        *,
        alone: bool = False,
    ) -> None:
        estimator = finger.estimator
        assert isinstance(estimator, ContactEstimator)  # noqa: S101
        settings = estimator.settings
        self._alone = alone
        layout = FingerLayout(
            estimator.layout.size, estimator.layout.lasting, settings.late, 0 if alone else RECENT_STATES,
            not alone, WIRES[line.wire].part_bytes(),
        )  # fmt: skip
        ellipse = settings.surface == "ellipse"
        self.finger, self._line, self._place = finger, line, place
        self.module: FingerKernels = finger_module(
            estimator.model, estimator.layout, layout, ellipse=ellipse, mode=mode, wire=line.wire
        )
        self.memory = FingerMemory(layout)
        self.answer = np.zeros(PART_BYTES if line.wire == CLASSIC else COMMAND_BYTES, dtype=np.uint8)
        """The frame of the last command, where commands are frames."""
        sizes = REPORT_BYTES if line.report_ids else ()
        self.report_frames = tuple(np.zeros(size, dtype=np.uint8) for size in sizes)
        """Both frames of the last contact that was told by :meth:`tell`, and that of the slip margin."""
        self.lent = False
        self._friction: GraspFriction | None = None  # that has lent
        self._shared = shared
        self._f, self._t = self.memory.f, self.memory.t
        # one number of an array costs three times as much as one of a view of it
        self._reals, self._wholes = self._f.data, self._t.data
        compile_now(self.module, line.wire, self._f, self._t, self.answer)
        self._step = bound_step(self.module, line.wire, self._f, self._t, shared, self.answer)
        self._force_at = layout.reals["STATE_NORMAL_FORCE"]
        self._displacement_at = layout.reals["STATE_DISPLACEMENT"]
        self._state = self.memory.section("STATE")
        self._news = layout.wholes["NEWS_STAMP"], layout.wholes["NEWS_SEQ"]
        self._given = layout.reals["GRIP_HELD"], layout.reals["GRIP_ADJUSTMENT"]
        self._turn = tuple(layout.wholes[f"TURN_{name}"] for name in ("COMMANDED", "SEQ", "GIVEN_REASON"))
        quiet = (
            "INPUT_IS_HEARD", "INPUT_HEARD", "TURN_STARTED", "TURN_COMMANDED", "SETUP_RENEWAL",
            "INPUT_CONDITION",
        )  # fmt: skip
        self._quiet = tuple(layout.wholes[name] for name in quiet)
        self._time_out_at = layout.reals["RULE_TIME_OUT"]
        tells = ("TURN_REPORT_DUE", "INPUT_CONDITION", "TURN_TOLD", "TURN_NOTED", "TURN_FETCHED")
        self._tells = tuple(layout.wholes[name] for name in tells)
        self._history = self.memory.section("HISTORY").reshape(-1, HISTORY_CHANNELS)
        self._stamps, self._numbers = map(self.memory.section, ("HISTORY_STAMP", "HISTORY_SEQ"))
        self._most_unfetched = len(self._history) // 2
        self._lifetime = 0  # [ns] of a command
        self._seen = 0  # states that were believed when the objects looked last

    def step(self, frame: np.ndarray, length: int, arrival: int, now: int) -> int:
        """Answer a frame; what is done is told in bits, and LEFT_ALONE means nothing at all."""
        return self._step(frame, length, arrival, now)

    def step_part(self, frame: np.ndarray, length: int, part: int, arrival: int, now: int) -> int:
        """Take the frame number ``part``, from 1, of those that make a state; answer with the last one."""
        return self._step(frame, part, arrival, now) if length == PART_BYTES else LEFT_ALONE

    def step_values(self, values: Floats, counter: int, stamp: int, arrival: int, now: int) -> int:
        """Answer the values of a state, as :meth:`step`; the command is :meth:`command_given`."""
        return self._step(values, counter, stamp, arrival, now)

    def lend(self, controller: GripController, periods: tuple[float, float]) -> bool:
        """Hand everything to the memory; return whether that was possible."""
        lifetime = self.finger.controller.limits.lifetime
        self._lifetime = round(lifetime * NS)
        if not self._line.carries(lifetime):
            return False
        memory = self.memory
        self.finger.write_to(memory, controller.wanted[1], periods)
        if not self._alone:
            controller.friction.write_to(memory, self.finger.name, controller.wanted_known)
            self._friction = controller.friction
        self._line.write_to(memory, lifetime)
        if not self._line.can_hand_over(memory):
            return False
        memory["SETUP_FINGER"], memory["SETUP_FINGERS"] = self._place.number, self._place.fingers
        memory["SETUP_THUMB"], memory["SETUP_ALONE"] = self._place.thumb, self._alone
        memory["TURN_NOTED"] = memory["TURN_FETCHED"] = self._seen = 0
        self.lent = True
        return True

    def look(self) -> KeptStates | None:
        """Let the objects see what is reported, and return what :meth:`take_back` does, now and then."""
        memory = self.memory
        noted = memory["TURN_NOTED"]
        kept = self._fetched() if noted - memory["TURN_FETCHED"] >= FETCHED_STATES else None
        is_new, self._seen = noted != self._seen, noted
        self.finger.read_contact(memory, self._state_at(noted - 1) if is_new else None)
        return kept

    def tell(self, now: int) -> bool:
        """Put contact and slip margin into :attr:`report_frames`; False: the objects have to tell them."""
        frames = self.report_frames
        return bool(frames) and bool(self.module.finger_report(self._f, self._t, now, *frames))

    def has_more_to_tell(self, now: int) -> bool:
        """Return whether the objects have something to tell, or to fetch."""
        whole, (due, condition, told, noted, fetched) = self._wholes, self._tells
        if now >= whole[due] or whole[condition] != whole[told]:
            return True
        return bool(whole[noted] - whole[fetched] >= self._most_unfetched)

    def told(self, periods: tuple[float, float]) -> None:
        """Let the memory know that the objects have reported what :meth:`look` showed them."""
        self.finger.write_told(self.memory, periods)

    def take_back(self) -> KeptStates:
        """Hand everything to the objects; return the states believed since they were fetched last."""
        memory = self.memory
        kept = self._fetched()
        values = memory.section("STATE").tolist()
        last = FingertipState(memory["INPUT_STAMP"], self.finger.name, memory["INPUT_SEQ"], *values)
        self.finger.read_from(memory, memory["TURN_NOTED"], last)
        self._line.read_from(memory)
        if self._friction is not None:
            self._friction.read_from(memory, self.finger.name)
        self.lent = False
        return kept

    def read_counters(self) -> None:
        """Let the objects know what was counted of frames; the memory stays in force."""
        if self.lent:
            self._line.read_from(self.memory)

    def is_quiet(self, now: int) -> bool:
        """Return whether a tick has nothing to do: no silence, and no command to renew."""
        whole, (is_heard, heard, started, commanded, renewal, condition) = self._wholes, self._quiet
        is_known = whole[is_heard] and now - whole[heard] <= self._reals[self._time_out_at]
        is_fresh = not whole[started] or now - whole[commanded] < whole[renewal]
        return bool(is_known and is_fresh and whole[condition] <= DEGRADED)

    def felt(self) -> tuple[float, float]:
        """Return normal force [N] and displacement [m] of the present state."""
        return self._reals[self._force_at], self._reals[self._displacement_at]

    def state_taken(self) -> Unmade:
        """Return the present state."""
        stamp, seq = map(self._wholes.__getitem__, self._news)
        return Unmade(FingertipState, self.finger.name, stamp, (seq, *self._state.tolist()))

    def command_given(self) -> Unmade:
        """Return the last command."""
        stamp, seq, reason = map(self._wholes.__getitem__, self._turn)
        force, adjustment = map(self._reals.__getitem__, self._given)
        rest = seq, force, adjustment, REASONS[reason], stamp + self._lifetime
        return Unmade(ForceCommand, self.finger.name, stamp, rest)

    def command_numbers(self) -> tuple[int, float, float, int, int]:
        """Return counter, force [N], its change [N], reason and lifetime [ns] of the last command."""
        _, seq, reason = map(self._wholes.__getitem__, self._turn)
        force, adjustment = map(self._reals.__getitem__, self._given)
        return seq, force, adjustment, reason, self._lifetime

    @property
    def runs_by(self) -> str:
        """What runs the step: C, numba, or Python where nothing is compiled."""
        if isinstance(self.module, FingerKernelsC):
            return "C"
        return "Python" if isinstance(self.module.finger_step, FunctionType) else "numba"

    @property
    def wire(self) -> str:
        """How its states travel, see :mod:`vegrip.transport.codec.line`."""
        return self._line.wire

    @property
    def state_id(self) -> int:
        """Identifier of the frames of states."""
        return self._line.state_id

    @property
    def command_id(self) -> int:
        """Identifier of the frames of commands."""
        return self._line.command_id

    @property
    def report_ids(self) -> tuple[int, ...]:
        """Identifiers of :attr:`report_frames`."""
        return self._line.report_ids

    @property
    def need(self) -> float:
        """What the finger needs [N]; NaN without a command."""
        return float(self._shared[self._place.number])

    def _fetched(self) -> KeptStates:
        """Return the states that were not fetched yet; the objects keep them, too."""
        memory = self.memory
        noted, fetched = memory["TURN_NOTED"], memory["TURN_FETCHED"]
        memory["TURN_FETCHED"] = noted
        kept = self._rows(max(fetched, noted - self.memory.layout.history), noted)
        self.finger.past.extend(kept)
        return kept

    def _state_at(self, number: int) -> FingertipState:
        """Return a state by its number in the history."""
        row = number % max(len(self._history), 1)
        values = self._history[row, :-1].tolist()
        return FingertipState(int(self._stamps[row]), self.finger.name, int(self._numbers[row]), *values)

    def _rows(self, start: int, end: int) -> KeptStates:
        """Return copies of states by their numbers in the history."""
        rows = self._history
        order = np.arange(start, end) % max(len(rows), 1)
        return KeptStates(self.finger.name, self._stamps[order], self._numbers[order], rows[order])
