"""The numbers of one finger: where they lie, and the compiled step that works on them.

What a finger does is one text (:mod:`vegrip.grip.kernels`), which C, numba or plain Python runs on the
numbers of :mod:`vegrip.grip.layout`. Here they have a place, and the calls are bound to it. What a finger
does with them stands in :mod:`vegrip.grip.finger`, what it reports in :mod:`vegrip.grip.finger_reports`.
"""

import struct
from dataclasses import dataclass
from numbers import Real
from types import FunctionType
from typing import Final

import numpy as np

from vegrip import messages
from vegrip.estimator import ContactEstimator
from vegrip.estimator.memory import CHANNELS, FingerMemory
from vegrip.grip import compiled
from vegrip.grip.background_diagnosis import KeptStates
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.layout import HISTORY_CHANNELS, FingerLayout
from vegrip.grip.own_estimate import STAND_IN, OwnEstimate
from vegrip.grip.wires import COMMAND_BYTES, REPORT_BYTES
from vegrip.model.native import ModuleC, bound_call
from vegrip.transport.codec.frame_codec import Line
from vegrip.types import Floats

RECENT_STATES: Final = 2000
"""States kept for a successor: four seconds at 500 Hz, some relaxation times and mostly the first touch."""
FETCHED_STATES: Final = 64
"""States that are fetched from the memory at once."""
FIRST_QUANTITY: Final = messages.FingertipState._fields.index("normal_force")  # type: ignore[attr-defined]
LARGEST_WHOLE: Final = (1 << 63) - 1
"""A counter or time beyond counts as this one."""
NOT_NUMBERS: Final = (struct.error, TypeError, ValueError, OverflowError)
"""What something raises that is to be taken as numbers and holds none."""
OF_ESTIMATOR: Final = ("ESTIMATOR", "REWIND", "REWIND_STATE", "LATER")
"""Sections that do not move to the memory of another estimator."""


def as_whole(number: object) -> int:
    """Return a counter, or a time [ns] of which parts do not count; one that is none raises NOT_NUMBERS."""
    if not isinstance(number, Real):
        raise TypeError(f"{number!r} is no number")
    whole: int = int(number)  # type: ignore[call-overload]
    return whole if -LARGEST_WHOLE <= whole <= LARGEST_WHOLE else LARGEST_WHOLE


@dataclass(frozen=True)
class Place:
    """Which finger of how many; ``thumb`` is the number of the one the others press against, or -1."""

    number: int
    fingers: int
    thumb: int


class FingerStep:
    """The memory of a finger and the calls of its compiled step.

    Args:
        name: of the finger.
        estimator: of its contact; a :class:`vegrip.ContactEstimator` is computed by the step.
        place: in the grasp.
        shared: what the fingers of the grasp share.
        line: how its frames travel; None: its states come as messages.
        mode: what runs the step, see :func:`~vegrip.grip.compiled.finger_module`.
        alone: whether nothing but the step works on it, as in firmware: no history is kept.

    """

    def __init__(
        self,
        name: str,
        estimator: Estimator,
        place: Place,
        shared: GraspMemory,
        *,
        line: Line | None = None,
        mode: str = "",
        alone: bool = False,
    ) -> None:
        self.name, self.place, self.shared, self.alone = name, place, shared, alone
        self.line = line
        self.is_on_line = False
        """Whether the memory has the counters of the line, and not its codec."""
        self._mode = mode
        self.estimator = estimator
        self.memory = FingerMemory(self._layout_of(estimator))
        self._build(estimator)
        memory = self.memory
        memory["SETUP_FINGER"], memory["SETUP_FINGERS"] = place.number, place.fingers
        memory["SETUP_THUMB"] = place.thumb

    # its parts

    def replace_estimator(self, estimator: Estimator, module: compiled.FingerKernels | None = None) -> None:
        """Go on with ``estimator``, which knows the past but for the very last samples.

        ``module`` is that of its step, if it has been compiled beside the loop (:meth:`module_of`).
        """
        known = estimator.contact_estimate().stamp
        for state in self.past.after(known):
            estimator.assimilate(state)
        self._build(estimator, module)
        self.memory["TURN_HAS_MARGIN"] = 0

    def module_of(self, estimator: Estimator) -> compiled.FingerKernels:
        return self._module(estimator, self._layout_of(estimator))

    @property
    def runs_by(self) -> str:
        """What runs the step: C, numba, or Python where nothing is compiled."""
        if isinstance(self.module, ModuleC):
            return "C"
        return "Python" if isinstance(self.module.finger_step, FunctionType) else "numba"

    def _layout_of(self, estimator: Estimator) -> FingerLayout:
        own = not isinstance(estimator, ContactEstimator)
        places = STAND_IN.layout if own else estimator.layout  # type: ignore[attr-defined]
        late = 0 if own else estimator.settings.late  # type: ignore[attr-defined]
        if self.alone:
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
        memory.take_over(self.memory, () if estimator is self.estimator else OF_ESTIMATOR)
        self.memory, self.estimator = memory, estimator
        self.own: OwnEstimate | None = None
        if isinstance(estimator, ContactEstimator):
            estimator.mount(memory, self.name)
            memory["PUBLISHED_CONFIDENCE"] = estimator.settings.confidence
        else:
            self.own = OwnEstimate(estimator, memory, self.shared, self.place.number)
        self._bind()
        self._bind_line()

    def _bind_line(self) -> None:
        f, t = self.memory.f, self.memory.t
        self.answer_frame = np.zeros(COMMAND_BYTES, dtype=np.uint8)
        """The frame of the last command, where states are frames."""
        sizes = REPORT_BYTES if self.line is not None and self.line.report_ids else ()
        self.report_frames = tuple(np.zeros(size, dtype=np.uint8) for size in sizes)
        """Both frames of the contact, and that of the slip margin, of :meth:`report_as_frames`."""
        compiled.compile_now(self.module, self.layout, f, t, self.answer_frame)
        self.answer_bytes = compiled.bound_step(self.module, f, t, self.shared.array, self.answer_frame)

    def _bind(self) -> None:
        """Look up once what every state asks for."""
        f, t, g, memory = self.memory.f, self.memory.t, self.shared.array, self.memory
        layout = memory.layout
        # one number of an array costs three times as much as one of a view of it
        self.reals, self.wholes = f.data, t.data
        self._values = np.zeros(len(CHANNELS))
        self._bytes = self._values.data.cast("B")
        self._pack = struct.Struct(f"={len(CHANNELS)}d").pack_into
        if not self.alone:
            self.answer, self.sense, self.judge = (
                bound_call(self.module, f"finger_{name}", f, t, g, self._values)
                for name in ("message", "sense", "judge")
            )
            self.take, self.bound, self.need, self.settle, self.watch, self.hold_last = (
                bound_call(self.module, f"finger_{name}", f, t, g)
                for name in ("take", "bound", "need", "settle", "watch", "hold_last")
            )
        self._felt = layout.reals["STATE_NORMAL_FORCE"], layout.reals["STATE_DISPLACEMENT"]
        self._state = memory.section("STATE")
        self._news = layout.wholes["NEWS_STAMP"], layout.wholes["NEWS_SEQ"]
        self.given = layout.reals["GRIP_HELD"], layout.reals["GRIP_ADJUSTMENT"]
        """Places of what a command is made of, as :attr:`turn`; :attr:`quiet`: of what a tick asks."""
        self.turn = tuple(layout.wholes[f"TURN_{name}"] for name in ("COMMANDED", "SEQ", "GIVEN_REASON"))
        quiet = (
            "INPUT_IS_RECEIVED", "INPUT_RECEIVED", "TURN_STARTED", "TURN_COMMANDED", "SETUP_RENEWAL",
            "INPUT_CONDITION",
        )  # fmt: skip
        self.quiet = tuple(layout.wholes[name] for name in quiet)
        self.time_out_at = layout.reals["RULE_TIME_OUT"]
        self._history = memory.section("HISTORY").reshape(-1, HISTORY_CHANNELS)
        self._kept = layout.wholes["TURN_NOTED"], layout.wholes["TURN_FETCHED"]
        self._stamps, self._numbers = map(memory.section, ("HISTORY_STAMP", "HISTORY_SEQ"))

    # states in

    def put(self, state: messages.FingertipState) -> tuple[int, int] | None:
        """Put the quantities of ``state`` where the next call takes them; return its counter and stamp.

        None: it holds something else than numbers.
        """
        seq, stamp = state.seq, state.stamp
        try:
            self._pack(self._bytes, 0, *state[FIRST_QUANTITY:])  # type: ignore[index]
            if type(seq) is type(stamp) is int and 0 <= seq | stamp <= LARGEST_WHOLE:
                return seq, stamp
            return as_whole(seq), as_whole(stamp)
        except NOT_NUMBERS:
            return None

    def put_values(self, values: Floats) -> None:
        self._values[:] = values

    def felt(self) -> tuple[float, float]:
        """Return normal force [N] and displacement [m] of the last state."""
        force, displacement = self._felt
        return self.reals[force], self.reals[displacement]

    def state(self) -> messages.FingertipState:
        stamp, seq = self._news
        return messages.FingertipState(self.wholes[stamp], self.name, self.wholes[seq], *self._state.tolist())

    @property
    def past(self) -> KeptStates:
        noted = self.memory["TURN_NOTED"]
        return self._rows(max(noted - len(self._history), 0), noted)

    def fetch(self, *, everything: bool = False) -> KeptStates | None:
        """Return the states that were accepted and not fetched yet, None while they are few."""
        memory = self.memory
        noted, fetched = memory["TURN_NOTED"], memory["TURN_FETCHED"]
        if noted - fetched < (1 if everything else FETCHED_STATES):
            return None
        memory["TURN_FETCHED"] = noted
        return self._rows(max(fetched, noted - len(self._history)), noted)

    def is_half_full(self) -> bool:
        """Return whether half of the history is to be fetched."""
        whole, (noted, fetched) = self.wholes, self._kept
        return bool(whole[noted] - whole[fetched] >= len(self._history) // 2)

    def _rows(self, start: int, end: int) -> KeptStates:
        rows = self._history
        order = np.arange(start, end) % len(rows)
        return KeptStates(self.name, self._stamps[order], self._numbers[order], rows[order])

    # frames in

    @property
    def on_wire(self) -> Line:
        """How its frames travel; its ``report_ids`` are those of :attr:`report_frames`."""
        assert self.line is not None  # noqa: S101 (asked only of a finger with frames)
        return self.line

    def follow_line(self, line: Line | None, mode: str = "") -> None:
        """Take the frames of ``line`` from now on; None: messages alone."""
        self.leave_line()
        self.line = line
        if mode != self._mode:
            self._mode = mode
            self._build(self.estimator)
        else:
            self._bind_line()

    def take_line(self, lifetime: float) -> bool:
        """Let the memory have the counters of the line; return whether frames can be taken.

        ``lifetime`` [s] is that of a command.
        """
        line = self.line
        if not self.is_on_line and line is not None and line.carries(lifetime):
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

    def report_as_frames(self, now: int) -> bool:
        """Put contact and slip margin into :attr:`report_frames`; False: they must go as messages."""
        frames = self.report_frames
        return bool(frames) and bool(self.module.finger_report(self.memory.f, self.memory.t, now, *frames))
