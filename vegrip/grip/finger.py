"""One finger of a grasp: the memory of its step, and what is read of it.

What a finger does is one text (:mod:`vegrip.grip.kernels`), which C, numba or plain Python runs on the
numbers of :mod:`vegrip.grip.layout`. Here they have a place, are called by their names, and become messages.
States come as messages (:meth:`GraspFinger.answer`) or as frames (:meth:`GraspFinger.step`).

An estimator, a policy or a share of the grasp in Python takes part between the halves of the step. That costs
what the Python costs, and some 20 us; frames are then decoded to messages.
"""

import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from types import FunctionType
from typing import Any, Final, TypeVar

import numpy as np

from vegrip import messages
from vegrip.clock import NS
from vegrip.estimator import ContactEstimator
from vegrip.estimator.estimator import quantile
from vegrip.estimator.learning import Learned
from vegrip.estimator.memory import CHANNELS, FingerMemory
from vegrip.grip import compiled
from vegrip.grip.background_diagnosis import KeptStates
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.layout import HISTORY_CHANNELS, MARGIN, FingerLayout, write_choice, write_rules
from vegrip.grip.own_estimate import STAND_IN, OwnEstimate
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.policy import GripPolicy
from vegrip.grip.settings import ControlSettings, apply_policy, make_policy
from vegrip.grip.wires import COMMAND_BYTES, REPORT_BYTES
from vegrip.model.native import ModuleC, bound_call
from vegrip.transport.codec.frame_codec import Line
from vegrip.types import Floats

Told = TypeVar("Told", messages.ContactEstimate, messages.SlipMargin)
Wanted = tuple[float, float]
"""Margin to keep [-], and the one-sided confidence to keep it with."""

RENEWAL: Final = 0.25
"""Part of its lifetime after which a command is renewed: three of them may get lost."""
RECENT_STATES: Final = 2000
"""States kept for a successor: four seconds at 500 Hz, some relaxation times and mostly the first touch."""
FETCHED_STATES: Final = 64
"""States that are fetched from the memory at once."""
NO_QUICKEST: Final = 1 << 62
"""[ns] No state has come yet, see :mod:`vegrip.grip.kernels.watchdog`."""
LARGEST_WHOLE: Final = (1 << 63) - 1
"""A counter or stamp beyond counts as this one."""

NO_MARGIN: Final = dict.fromkeys(("lower_bound", "force_reserve", "time_to_slip", "earliest_slip"), math.nan)
DEGRADED: Final = int(messages.Condition.DEGRADED)
FIRST_QUANTITY: Final = messages.FingertipState._fields.index("normal_force")  # type: ignore[attr-defined]
CONDITIONS: Final = tuple(messages.Condition)
REASONS: Final = tuple(messages.Reason(number) for number in range(len(messages.Reason)))

FRESH: Final[Mapping[str, float]] = {
    "GRIP_HELD": math.nan, "GRIP_ENVELOPE": math.nan, "GRIP_ELAPSED": -math.inf, "GRIP_PRESENT": -math.inf,
    "GRIP_MEDIAN": -math.inf, "GRIP_PROVEN": math.inf, "TRANSFER_FORCE": math.nan, "TRANSFER_LOAD": math.nan,
    "TRANSFER_ARM": math.nan, "TURN_REASON": int(messages.Reason.HOLD), "TURN_TOLD": -1,
    "TAKEN_BOUND": math.nan,
}  # fmt: skip
"""What of a memory is not zero before the first state, besides :data:`UNHEARD`."""
UNHEARD: Final[Mapping[str, float]] = {
    "INPUT_CONDITION": int(messages.Condition.MISSING), "INPUT_QUICKEST": NO_QUICKEST,
    "WATCH_NOISE_LAST": math.nan, "WATCH_REPEAT_LIMIT": math.inf, "WATCH_LEVEL": math.nan,
}  # fmt: skip
"""The same of the input, as it is before the first state."""
UNKNOWN_AT_FIRST: Final = ("REPEATED", "REPEATED_FORCE", "CONFIRMED")
INPUT_SECTIONS: Final = ("INPUT", "WATCH", "FAULTS")
OF_ESTIMATOR: Final = ("ESTIMATOR", "REWIND", "REWIND_STATE", "LATER")
"""Sections that do not move to the memory of another estimator."""


@dataclass(frozen=True)
class Place:
    """Which finger of how many; ``thumb`` is the number of the one the others press against, or -1."""

    number: int
    fingers: int
    thumb: int


class GraspFinger:
    """A finger: a view of its memory, and the calls that work on it.

    Args:
        name: of the finger.
        estimator: of its contact; a :class:`vegrip.ContactEstimator` is computed by the step.
        settings: how the grasp is controlled.
        place: in the grasp.
        shared: what the fingers of the grasp share.
        phase: share of a report period by which its reports keep their distance from those of the first
            finger; the reports of all fingers at once would delay the commands behind them.
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
        self.line = line
        self.is_on_line = False
        """Whether the memory has the counters of the line, and not its codec."""
        self.wanted: Wanted = settings.grip.wanted_margin, settings.grip.probability
        """What is asked of the estimate where slip would not be felt."""
        self.policy: GripPolicy | None = None if settings.is_built_in else make_policy(settings)
        """A policy in Python; None: the step has it."""
        self._place, self._shared, self._mode, self._alone = place, shared, mode, alone
        self._phase = phase
        self._healthy = self._learned_at = -math.inf  # [ns] when last told
        self._healths = self._learned_count = 0  # how often
        self._forgotten = 0  # how often the policy was told to forget
        self._lifetime = 0  # [ns] of a command
        self._estimator = estimator
        self.layout = self._layout_of(estimator)
        self.memory = FingerMemory(self.layout)
        self._build(estimator)
        memory = self.memory
        self._put_first({**FRESH, **UNHEARD})
        memory["SETUP_FINGER"], memory["SETUP_FINGERS"] = place.number, place.fingers
        memory["SETUP_THUMB"] = place.thumb
        self._settings = settings
        self.apply(settings, self.wanted)

    # its parts

    @property
    def estimator(self) -> Estimator:
        return self._estimator

    def replace_estimator(self, estimator: Estimator, module: compiled.FingerKernels | None = None) -> None:
        """Go on with ``estimator``, which knows the past but for the very last samples.

        ``module`` is that of its step, if it has been compiled beside the loop (:meth:`module_of`).
        """
        known = estimator.contact_estimate().stamp
        for state in self.past.after(known):
            estimator.assimilate(state)
        self._build(estimator, module)
        self.memory["TURN_HAS_MARGIN"] = 0

    def follow_line(self, line: Line | None, mode: str = "") -> None:
        """Take the frames of ``line`` from now on; None: messages alone."""
        self.leave_line()
        self.line = line
        if mode != self._mode:
            self._mode = mode
            self._build(self._estimator)
        else:
            self._bind_line()

    def module_of(self, estimator: Estimator) -> compiled.FingerKernels:
        return self._module(estimator, self._layout_of(estimator))

    def _layout_of(self, estimator: Estimator) -> FingerLayout:
        own = not isinstance(estimator, ContactEstimator)
        places = STAND_IN.layout if own else estimator.layout  # type: ignore[attr-defined]
        late = 0 if own else estimator.settings.late  # type: ignore[attr-defined]
        if self._alone:
            return FingerLayout(places, late)
        return FingerLayout(places, late, RECENT_STATES, True)

    def _module(self, estimator: Estimator, layout: FingerLayout) -> compiled.FingerKernels:
        found = estimator if isinstance(estimator, ContactEstimator) else STAND_IN
        ellipse = isinstance(found, ContactEstimator) and found.settings.surface == "ellipse"
        return compiled.finger_module(found.model, layout, ellipse=ellipse, mode=self._mode)

    def _build(self, estimator: Estimator, module: compiled.FingerKernels | None = None) -> None:
        """Have a memory and calls for this estimator and the present wire; what is known moves there."""
        layout = self.layout = self._layout_of(estimator)
        self.module = module if module is not None else self._module(estimator, layout)
        memory = FingerMemory(layout)
        memory.take_over(self.memory, () if estimator is self._estimator else OF_ESTIMATOR)
        self.memory, self._estimator = memory, estimator
        self._own: OwnEstimate | None = None
        if isinstance(estimator, ContactEstimator):
            estimator.mount(memory, self.name)
            memory["TOLD_CONFIDENCE"] = estimator.settings.confidence
        else:
            self._own = OwnEstimate(estimator, memory, self._shared, self._place.number)
        self._bind()
        self._bind_line()

    def _bind_line(self) -> None:
        f, t = self.memory.f, self.memory.t
        self.answer_frame = np.zeros(COMMAND_BYTES, dtype=np.uint8)
        """The frame of the last command, where states are frames."""
        sizes = REPORT_BYTES if self.line is not None and self.line.report_ids else ()
        self.report_frames = tuple(np.zeros(size, dtype=np.uint8) for size in sizes)
        """Both frames of the last contact that was told by :meth:`tell`, and that of the slip margin."""
        compiled.compile_now(self.module, self.layout, f, t, self.answer_frame)
        self._step = compiled.bound_step(self.module, f, t, self._shared.array, self.answer_frame)

    def _bind(self) -> None:
        """Look up once what every state asks for."""
        f, t, g, memory = self.memory.f, self.memory.t, self._shared.array, self.memory
        layout = memory.layout
        # one number of an array costs three times as much as one of a view of it
        self._reals, self._wholes = f.data, t.data
        self._values = np.zeros(len(CHANNELS))
        self._bytes = self._values.data.cast("B")
        self._pack = struct.Struct(f"={len(CHANNELS)}d").pack_into
        if not self._alone:
            self._message, self._sense, self._judge = (
                bound_call(self.module, f"finger_{name}", f, t, g, self._values)
                for name in ("message", "sense", "judge")
            )
            self._take, self._bound, self._need, self._settle, self._watch, self._ride_out = (
                bound_call(self.module, f"finger_{name}", f, t, g)
                for name in ("take", "bound", "need", "settle", "watch", "ride_out")
            )
        self._felt = layout.reals["STATE_NORMAL_FORCE"], layout.reals["STATE_DISPLACEMENT"]
        self._state = memory.section("STATE")
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
        self._history = memory.section("HISTORY").reshape(-1, HISTORY_CHANNELS)
        self._stamps, self._numbers = map(memory.section, ("HISTORY_STAMP", "HISTORY_SEQ"))

    def apply(self, settings: ControlSettings, wanted: Wanted) -> None:
        """Go on with other settings; what has been learned and what is held stay.

        ``wanted`` of it is what the grasp makes of them (:attr:`vegrip.grip.GripController.wanted`).
        """
        self.leave_line()  # it says how long a command lives
        memory, self.wanted, self._settings = self.memory, wanted, settings
        write_rules(memory, settings)
        memory["RULE_QUANTILE"] = quantile(wanted[1])
        self._lifetime = round(settings.limits.lifetime * NS)
        memory["SETUP_RENEWAL"] = math.ceil(RENEWAL * settings.limits.lifetime * NS)
        if self.policy is not None:
            apply_policy(self.policy, settings)
        if not self._alone:
            write_choice(memory, settings)
            policy = self.policy
            memory["CHOICE_ASKS"] = settings.policy == MARGIN if policy is None else policy.uses_least_force
            memory["CHOICE_SHARE"] = bool(settings.contacts)
        self.is_whole = not self.why_split
        """Whether one call answers a state: no estimator, policy or share in Python takes part."""
        self._set_due()

    # states in

    @property
    def why_split(self) -> str:
        """What takes part in Python, in words; empty: nothing."""
        reasons = {
            "the estimator is of another make": self._own is not None,
            f"the policy is {self._settings.policy}": self.policy is not None,
            "the places of the contacts are given": bool(self._settings.contacts),
        }
        return next((reason for reason, holds in reasons.items() if holds), "")

    def answer(self, state: messages.FingertipState, now: int) -> int:
        """Answer one state that arrived at ``now`` [ns]; return what was done, in bits."""
        self._put(state)
        seq, stamp = state.seq, state.stamp
        if not (0 <= seq <= LARGEST_WHOLE and 0 <= stamp <= LARGEST_WHOLE):
            seq, stamp = _whole(seq), _whole(stamp)
        return self._message(seq, stamp, now)

    def answer_values(self, values: Floats, seq: int, stamp: int, now: int) -> None:
        """Answer a state of which no message was made, as :meth:`answer`."""
        self._values[:] = values
        self._message(seq, stamp, now)

    def sense(self, state: messages.FingertipState, now: int) -> bool:
        """Take in one state and find what the finger needs; return whether the state is believed."""
        self._put(state)
        seq, stamp = _whole(state.seq), _whole(state.stamp)
        if self._own is None and self.policy is None:
            return bool(self._sense(seq, stamp, now))
        believed = bool(self._judge(seq, stamp, now))
        if believed and self._own is not None:
            self._own.take(state, self.wanted, asks=bool(self.memory["CHOICE_ASKS"]))
        elif believed:
            self._take(now)
        if self._bound(now) and self.policy is not None:
            self._ask(self.policy)
        self._need(now)
        self._let_forget()
        return believed

    def settle(self, now: int, share: float = math.nan) -> int:
        """Command the finger's share of the grasp, once it has begun; return what was done, in bits.

        ``share`` [N] counts where the places of the contacts are given.
        """
        if self._settings.contacts:
            self.memory["OWN_SHARE"] = share
        return self._settle(now)

    def watch(self, now: int) -> bool:
        """Look for silence, and ride it out by the clock; return whether a command is due."""
        is_due = bool(self._watch(now))
        self._let_forget()
        return is_due

    def ride_out(self, now: int) -> bool:
        """Ride out a fault of the node itself, without the estimate; return whether a command is due."""
        is_due = bool(self._ride_out(now))
        self._let_forget()
        return is_due

    def restart(self) -> None:
        """Forget input and contact but keep the command: the node is back from a fault of its own."""
        memory = self.memory
        self._estimator.reset()
        for section in INPUT_SECTIONS:
            memory.section(section)[:] = 0
        self._put_first(UNHEARD)
        memory["TURN_SEEN"] = memory["TURN_HAS_MARGIN"] = 0

    def _put_first(self, values: Mapping[str, float]) -> None:
        for key, value in values.items():
            self.memory[key] = value
        for section in UNKNOWN_AT_FIRST:
            self.memory.section(section)[:] = math.nan

    def note_broken(self, now: int) -> None:
        """Note that a frame of this finger arrived broken at ``now`` [ns]."""
        self.memory["INPUT_CORRUPT"], self.memory["INPUT_IS_CORRUPT"] = now, 1

    def _put(self, state: messages.FingertipState) -> None:
        self._pack(self._bytes, 0, *state[FIRST_QUANTITY:])  # type: ignore[index]

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

    # frames in

    @property
    def on_wire(self) -> Line:
        """How its frames travel; its ``report_ids`` are those of :attr:`report_frames`."""
        assert self.line is not None  # noqa: S101 (asked only of a finger with frames)
        return self.line

    def take_line(self) -> bool:
        """Let the memory have the counters of the line; return whether frames can be taken."""
        line, lifetime = self.line, self._settings.limits.lifetime
        if not self.is_on_line and line is not None and self.is_whole and line.carries(lifetime):
            line.write_to(self.memory, lifetime)
            self.is_on_line = True
        return self.is_on_line

    def leave_line(self) -> None:
        """Let the codec have the counters of the line: it decodes what comes next."""
        self.read_counters()
        self.is_on_line = False

    def read_counters(self) -> None:
        """Let the codec know what was counted of frames; the memory goes on counting."""
        if self.is_on_line:
            self.on_wire.read_from(self.memory)

    def step(self, frame: np.ndarray, length: int, arrival: int, now: int) -> int:
        """Answer a frame; what is done is told in bits, and LEFT_ALONE means nothing at all."""
        return self._step(frame, length, arrival, now)

    @property
    def runs_by(self) -> str:
        """What runs the step: C, numba, or Python where nothing is compiled."""
        if isinstance(self.module, ModuleC):
            return "C"
        return "Python" if isinstance(self.module.finger_step, FunctionType) else "numba"

    # what it commands

    @property
    def started(self) -> bool:
        return bool(self.memory["TURN_STARTED"])

    @property
    def held(self) -> float:
        """The force commanded last [N]; NaN before the start."""
        return self._reals[self._given[0]]

    @property
    def need(self) -> float:
        """What the finger needs [N], as the grasp knows it; NaN without a command."""
        return self._shared[self._place.number]

    def command(self) -> messages.ForceCommand:
        """Return the last command."""
        whole, real = self._wholes, self._reals
        (commanded, seq, reason), (held, adjustment) = self._turn, self._given
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

    # what it felt

    @property
    def condition(self) -> messages.Condition:
        return CONDITIONS[self._wholes[self._quiet[-1]]]

    @property
    def faults(self) -> dict[messages.Condition, int]:
        counts = zip(messages.Condition, self.memory.section("FAULTS").tolist(), strict=True)
        return {condition: count for condition, count in counts if count}

    @property
    def doubtful(self) -> bool:
        """Whether the normal force stands still; too early to call it frozen."""
        return bool(self.memory["INPUT_DOUBTFUL"])

    @property
    def lost(self) -> frozenset[str]:
        """Channels that had been there and now are not."""
        return compiled.channels_of(self.memory["INPUT_LOST"])

    @property
    def past(self) -> KeptStates:
        noted = self.memory["TURN_NOTED"]
        return self._rows(max(noted - len(self._history), 0), noted)

    def fetch(self, *, everything: bool = False) -> KeptStates | None:
        """Return the states that were believed and not fetched yet, None while they are few."""
        memory = self.memory
        noted, fetched = memory["TURN_NOTED"], memory["TURN_FETCHED"]
        if noted - fetched < (1 if everything else FETCHED_STATES):
            return None
        memory["TURN_FETCHED"] = noted
        return self._rows(max(fetched, noted - len(self._history)), noted)

    def felt(self) -> tuple[float, float]:
        force, displacement = self._felt
        return self._reals[force], self._reals[displacement]

    def state(self) -> messages.FingertipState:
        stamp, seq = self._news
        return messages.FingertipState(
            self._wholes[stamp], self.name, self._wholes[seq], *self._state.tolist()
        )

    def is_quiet(self, now: int) -> bool:
        """Return whether a tick has nothing to do: no silence, and no command to renew."""
        whole, (is_heard, heard, started, commanded, renewal, condition) = self._wholes, self._quiet
        is_known = whole[is_heard] and now - whole[heard] <= self._reals[self._time_out_at]
        is_fresh = not whole[started] or now - whole[commanded] < whole[renewal]
        return bool(is_known and is_fresh and whole[condition] <= DEGRADED)

    def _rows(self, start: int, end: int) -> KeptStates:
        rows = self._history
        order = np.arange(start, end) % max(len(rows), 1)
        return KeptStates(self.name, self._stamps[order], self._numbers[order], rows[order])

    # what it tells

    def contact(self, now: int) -> messages.ContactEstimate:
        """Return what is known of the contact at ``now`` [ns]; not valid while the input is not trusted."""
        contact = replace(
            self._estimator.contact_estimate(), finger=self.name, seq=self.memory["TURN_REPORTS"]
        )
        return contact if self._is_fresh else _untrusted(contact, self._age(now))

    def margin(self, now: int) -> messages.SlipMargin:
        """Return the slip margin at ``now`` [ns]; not valid while the input is not trusted."""
        return self._judged_margin(self._estimator.slip_margin(), now)

    def health(self, now: int) -> messages.ModelHealth:
        health = self._estimator.health()
        return replace(health, stamp=now, finger=self.name, seq=self._healths, condition=self.condition)

    def reports(self, now: int) -> Iterator[messages.Message]:
        """Yield what is due to be told: contact, margin, and less often the health of the model.

        A change of the condition is told at once.
        """
        memory, periods = self.memory, self._settings
        if memory["TURN_SEEN"] and memory["TURN_HAS_MARGIN"] and self._is_contact_due(now):
            first = memory["TURN_CONTACT_DUE"] == 0
            told = now - self._phase * periods.report_period * NS if first else now
            memory["TURN_REPORTED"] = int(told)
            margin = self._estimator.slip_margin()
            memory["TAKEN_BOUND"] = margin.lower_bound
            contact, margin = self.contact(now), self._judged_margin(margin, now)
            memory["TURN_REPORTS"] += 1
            memory["TURN_CONTACT_DUE"] = max(math.ceil(told + periods.report_period * NS), 1)
            self._set_due()
            yield contact
            yield margin
        is_due = self.health_due(now)
        if is_due or self.condition != memory["TURN_TOLD"]:
            memory["TURN_TOLD"] = self.condition
            if is_due:
                first = self._healthy == -math.inf
                self._healthy = now - self._phase * periods.health_period * NS if first else now
            self._set_due()
            yield self.health(now)
            self._healths += 1

    def health_due(self, now: int) -> bool:
        return _due(self._healthy, now, self._settings.health_period)

    def learned_messages(self, learned: Mapping[str, Learned], now: int) -> Iterator[messages.Message]:
        """Yield what is learned, one message for each parameter, when that is due."""
        period = self._settings.learned_period
        if not _due(self._learned_at, now, period):
            return
        first = self._learned_at == -math.inf
        self._learned_at = now - self._phase * period * NS if first else now
        for symbol, one in learned.items():
            filtered = messages.Estimate(one.filtered, one.raw.std, one.valid, one.raw.age)
            yield messages.LearnedParameter(
                now, self.name, self._learned_count, symbol, one.raw, filtered, one.excited
            )
            self._learned_count += 1

    def tell(self, now: int) -> bool:
        """Put contact and slip margin into :attr:`report_frames`; False: :meth:`reports` has to tell them."""
        frames = self.report_frames
        return bool(frames) and bool(self.module.finger_report(self.memory.f, self.memory.t, now, *frames))

    def has_more_to_tell(self, now: int) -> bool:
        """Return whether :meth:`reports` has something to tell, or half of the history is to be fetched."""
        whole, (due, condition, told, noted, fetched) = self._wholes, self._tells
        if now >= whole[due] or whole[condition] != whole[told]:
            return True
        return bool(whole[noted] - whole[fetched] >= len(self._history) // 2)

    def _is_contact_due(self, now: int) -> bool:
        # a clock that jumped back must not silence the reports
        return bool(now >= self.memory["TURN_CONTACT_DUE"] or now < self.memory["TURN_REPORTED"])

    def _set_due(self) -> None:
        memory = self.memory
        period = math.ceil(self._settings.report_period * NS)
        if period != memory["SETUP_REPORT_PERIOD"] and memory["TURN_CONTACT_DUE"]:
            memory["TURN_CONTACT_DUE"] = max(memory["TURN_REPORTED"] + period, 1)
        memory["SETUP_REPORT_PERIOD"] = period
        health = self._healthy + self._settings.health_period * NS
        memory["TURN_HEALTH_DUE"] = math.ceil(health) if health > 0.0 else 0
        memory["TURN_REPORT_DUE"] = min(memory["TURN_CONTACT_DUE"], memory["TURN_HEALTH_DUE"])

    def _judged_margin(self, margin: messages.SlipMargin, now: int) -> messages.SlipMargin:
        margin = replace(margin, finger=self.name, seq=self.memory["TURN_REPORTS"])
        return margin if self._is_fresh else _untrusted(margin, self._age(now), **NO_MARGIN)

    @property
    def _is_fresh(self) -> bool:
        return self.condition <= messages.Condition.DEGRADED

    def _age(self, now: int) -> float:
        memory = self.memory
        return max(0.0, (now - memory["TURN_USED"]) / NS) if memory["TURN_SEEN"] else math.inf


def _whole(number: int) -> int:
    return number if -LARGEST_WHOLE <= number <= LARGEST_WHOLE else LARGEST_WHOLE


def _due(last: float, now: int, period: float) -> bool:
    return now - last >= period * NS or now < last  # a clock that jumped back must not silence the reports


def _untrusted(message: Told, age: float, **unknown: float) -> Told:
    """Return ``message`` with nothing known of the present: any spread is possible."""
    values = {field.name: getattr(message, field.name) for field in fields(message)}
    found = {name: one for name, one in values.items() if isinstance(one, messages.Estimate)}
    vague = {name: replace(one, std=math.inf, valid=False, age=age) for name, one in found.items()}
    told: Any = {**vague, **unknown}
    return replace(message, **told)
