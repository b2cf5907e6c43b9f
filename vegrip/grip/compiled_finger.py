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
from vegrip.grip.compiled import FingerKernels, FingerKernelsC, finger_module
from vegrip.grip.finger import RECENT_STATES, GraspFinger
from vegrip.grip.layout import HISTORY_CHANNELS, FingerLayout
from vegrip.grip.memory import FingerMemory
from vegrip.grip.policies.margin_grip import MarginGrip
from vegrip.grip.settings import ControlSettings
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.runtime.telemetry import Unmade
from vegrip.transport.codec.line import Line
from vegrip.types import Floats

LEFT_ALONE: Final = 0
"""The compiled step did not take the frame, and changed nothing."""
REPORT: Final = 4
"""Bit of a step after which something is due to be told."""

STATE_BYTES: Final = 48
COMMAND_BYTES: Final = 24
REASONS: Final = tuple(Reason(number) for number in range(len(Reason)))
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

    The step has the margin grip alone, shares between thumb and fingers but not by the places of the
    ``contacts``, and takes friction as the finger's own estimator learns it: where friction is shared between
    the fingers or probed (``friction.shared``, ``friction.probing``), and for any other policy or estimator,
    the objects answer.
    """
    estimator, friction, grip = finger.estimator, settings.friction, settings.grip
    reasons = {
        f"the policy is {settings.policy}": not isinstance(finger.controller.policy, MarginGrip),
        "the places of the contacts are given": bool(settings.contacts),
        "friction is shared or probed": friction.shared or friction.probing,
        "the load is led by the lag of the drives": grip.drive_lag > 0.0,
        "the grip goes back to a proven need": grip.proven_time > 0.0,
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
        needs: what every finger of the grasp needs [N], NaN without a command; shared by all.
        mode: what runs the step, see :func:`~vegrip.grip.compiled.finger_module`.
        alone: whether nothing but the step works on it, as in firmware: no history is kept, and a clock that
            starts anew is followed.

    """

    def __init__(
        self,
        finger: GraspFinger,
        line: Line,
        place: Place,
        needs: Floats,
        mode: str = "",
        *,
        alone: bool = False,
    ) -> None:
        estimator = finger.estimator
        assert isinstance(estimator, ContactEstimator)  # noqa: S101
        settings = estimator.settings
        self._alone = alone
        layout = FingerLayout(estimator.layout.size, settings.late, 0 if alone else RECENT_STATES)
        ellipse = settings.surface == "ellipse"
        self.finger, self._line, self._place = finger, line, place
        self.module: FingerKernels = finger_module(
            estimator.model, estimator.layout, layout, ellipse=ellipse, mode=mode
        )
        self.memory = FingerMemory(layout)
        self.answer = np.zeros(COMMAND_BYTES, dtype=np.uint8)
        """The frame of the last command."""
        self.lent = False
        self._needs = needs
        self._f, self._t = self.memory.f, self.memory.t
        self._step = self.module.finger_step
        self._force_at = layout.reals["STATE_NORMAL_FORCE"]
        self._displacement_at = layout.reals["STATE_DISPLACEMENT"]
        self._state = self.memory.section("STATE")
        self._news = layout.wholes["NEWS_STAMP"], layout.wholes["NEWS_SEQ"]
        self._given = layout.reals["GRIP_HELD"], layout.reals["GRIP_ADJUSTMENT"]
        self._turn = tuple(layout.wholes[f"TURN_{name}"] for name in ("COMMANDED", "SEQ", "GIVEN_REASON"))
        self._lifetime = 0  # [ns] of a command

    def step(self, frame: np.ndarray, length: int, arrival: int, now: int) -> int:
        """Answer a frame; what is done is told in bits, and LEFT_ALONE means nothing at all."""
        done: int = self._step(self._f, self._t, self._needs, frame, length, arrival, now, self.answer)
        return done

    def lend(self, confidence: float, periods: tuple[float, float]) -> bool:
        """Hand everything to the memory; return whether that was possible."""
        lifetime = self.finger.controller.limits.lifetime
        self._lifetime = round(lifetime * NS)
        if not self._line.carries(lifetime):
            return False
        memory = self.memory
        self.finger.write_to(memory, confidence, periods)
        self._line.write_to(memory, lifetime)
        memory["SETUP_FINGER"], memory["SETUP_FINGERS"] = self._place.number, self._place.fingers
        memory["SETUP_THUMB"], memory["SETUP_ALONE"] = self._place.thumb, self._alone
        memory["TURN_NOTED"] = memory["TURN_FETCHED"] = 0
        self.lent = True
        return True

    def look(self) -> list[tuple[FingertipState, bool]]:
        """Let the objects see what is reported, and return what :meth:`take_back` does."""
        taken = self._fetched()
        self.finger.read_contact(self.memory, [state for state, _ in taken])
        return taken

    def told(self, periods: tuple[float, float]) -> None:
        """Let the memory know that the objects have reported what :meth:`look` showed them."""
        self.finger.write_told(self.memory, periods)

    def take_back(self) -> list[tuple[FingertipState, bool]]:
        """Hand everything to the objects; return the states believed meanwhile, and whether it touched."""
        memory = self.memory
        taken = self._fetched()
        values = memory.section("STATE").tolist()
        last = FingertipState(memory["INPUT_STAMP"], self.finger.name, memory["INPUT_SEQ"], *values)
        self.finger.read_from(memory, [state for state, _ in taken], last)
        self._line.read_from(memory)
        self.lent = False
        return taken

    def is_quiet(self, now: int) -> bool:
        """Return whether a tick has nothing to do: no silence, and no command to renew."""
        memory = self.memory
        heard = memory["INPUT_IS_HEARD"] and now - memory["INPUT_HEARD"] <= memory["RULE_TIME_OUT"]
        fresh = not memory["TURN_STARTED"] or now - memory["TURN_COMMANDED"] < memory["SETUP_RENEWAL"]
        return bool(heard and fresh and memory["INPUT_CONDITION"] <= 1)

    def felt(self) -> tuple[float, float]:
        """Return normal force [N] and displacement [m] of the present state."""
        return self._f.item(self._force_at), self._f.item(self._displacement_at)

    def state_taken(self) -> Unmade:
        """Return the present state."""
        stamp, seq = map(self._t.item, self._news)
        return Unmade(FingertipState, self.finger.name, stamp, (seq, *self._state.tolist()))

    def command_given(self) -> Unmade:
        """Return the last command."""
        stamp, seq, reason = map(self._t.item, self._turn)
        force, adjustment = map(self._f.item, self._given)
        rest = seq, force, adjustment, REASONS[reason], stamp + self._lifetime
        return Unmade(ForceCommand, self.finger.name, stamp, rest)

    @property
    def runs_by(self) -> str:
        """What runs the step: C, numba, or Python where nothing is compiled."""
        if isinstance(self.module, FingerKernelsC):
            return "C"
        return "Python" if isinstance(self.module.finger_step, FunctionType) else "numba"

    @property
    def state_id(self) -> int:
        """Identifier of the frames of states."""
        return self._line.state_id

    @property
    def command_id(self) -> int:
        """Identifier of the frames of commands."""
        return self._line.command_id

    @property
    def need(self) -> float:
        """What the finger needs [N]; NaN without a command."""
        return float(self._needs[self._place.number])

    def _fetched(self) -> list[tuple[FingertipState, bool]]:
        memory, name = self.memory, self.finger.name
        noted, fetched = memory["TURN_NOTED"], memory["TURN_FETCHED"]
        memory["TURN_FETCHED"] = noted
        rows = memory.section("HISTORY").reshape(-1, HISTORY_CHANNELS)
        stamps, numbers = memory.section("HISTORY_STAMP"), memory.section("HISTORY_SEQ")
        order = np.arange(max(fetched, noted - len(rows)), noted) % len(rows)
        found = zip(stamps[order].tolist(), numbers[order].tolist(), rows[order].tolist(), strict=True)
        return [
            (FingertipState(stamp, name, seq, *values[:-1]), values[-1] > 0.5) for stamp, seq, values in found
        ]
