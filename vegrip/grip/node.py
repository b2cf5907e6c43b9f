"""The node that grips: a grip controller with a lifecycle, on a bus."""

import logging
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from vegrip.errors import ConfigError
from vegrip.grip.background_diagnosis import MisfitDiagnoser, NoDiagnosis
from vegrip.grip.batch_text import STATE_BYTES
from vegrip.grip.compiled_batch import CompiledBatch, can_batch
from vegrip.grip.compiled_finger import LEFT_ALONE, CompiledFinger, Place, why_not_compiled
from vegrip.grip.compiled_packet import CompiledPackets, can_take_packets
from vegrip.grip.controller import GripController, need_of
from vegrip.grip.drive_log import DriveLog
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import GraspFinger
from vegrip.grip.known_objects import KnownObjects, ObjectFriction
from vegrip.grip.learned_store import LearnedStore, NoStore
from vegrip.grip.model_swap import ModelSwap
from vegrip.grip.settings import ControlSettings, make_share
from vegrip.grip.slip_table import describe_derived
from vegrip.host.realtime import NODE_PRIORITY
from vegrip.messages import (
    Condition,
    ContactEstimate,
    FingertipState,
    ForceCommand,
    Message,
    ModelHealth,
    NodeStatus,
)
from vegrip.runtime import NodeBase
from vegrip.runtime.packet_path import PacketAnswer
from vegrip.runtime.telemetry import Unmade
from vegrip.transport.codec.line import FingerLine
from vegrip.types import Floats

WHY_NO_LINES = (
    "they come through a map, in restored order (order_window) or by the hand's clock (estimate_clock)"
)


class GraspForce(NodeBase):
    """FingertipState in; ForceCommand, ContactEstimate, SlipMargin, ModelHealth, LearnedParameter out.

    The command comes first of every answer, because it is the one that is waited for. The reports are worked
    out when they are taken.

    Args:
        name: of the node.
        fingers: names of the fingers; states of others are counted in :attr:`rejected` and ignored.
        make_estimator: gives a new estimator for a finger; called by :meth:`configure`.
        settings: how the grasp is controlled.
        learned_store: of what the fingers learn; asked to save it by :meth:`cleanup`, when nothing is held.
        model_swap: builds new estimators when parameters of the fingertips change while the node runs.
        diagnoser: finds what a model lacks that fails.

    """

    exclusive_messages: tuple[type[Message], ...] = (ForceCommand,)
    heard_messages: tuple[type[Message], ...] = (FingertipState, ForceCommand, NodeStatus)  # also of rivals
    realtime_priority = NODE_PRIORITY

    def __init__(
        self,
        name: str,
        fingers: Sequence[str],
        make_estimator: Callable[[str], Estimator],
        settings: ControlSettings,
        learned_store: LearnedStore | None = None,
        model_swap: ModelSwap | None = None,
        diagnoser: MisfitDiagnoser | None = None,
    ) -> None:
        self.controller: GripController | None = None
        """What grips; None until the node is configured."""
        self._names = tuple(fingers)
        self._model_swap: ModelSwap | None = None
        self._compiled: dict[str, CompiledFinger] = {}
        self._lines: Mapping[str, FingerLine] = {}
        self._kernel_mode = ""
        self._batch: CompiledBatch | None = None
        self._packets: CompiledPackets | None = None
        self._shared = np.full(max(1, len(self._names)), np.nan)  # what the fingers of the grasp share
        super().__init__(name, settings)
        self._make_estimator = make_estimator
        self._learned_store = learned_store or NoStore()
        self._model_swap = model_swap
        self.diagnoser = diagnoser or NoDiagnosis()
        self._active = False
        self._why_not_probing = ""  # as it was last told
        self._drive_log = DriveLog(name)
        self._worn = False  # the fingers have a past
        self._is_at_fault = False  # of this node itself, not of its input

    @property
    def parameters(self) -> ControlSettings:
        """What can be changed while the node runs."""
        return self._parameters

    @parameters.setter
    def parameters(self, settings: ControlSettings) -> None:
        before = getattr(self, "_parameters", settings)
        self._parameters = settings
        self._take_back(self.fingers.values())
        self._begin_model_swap(before, settings)
        if self.controller is None:
            make_share(settings, self._names)  # says now what cannot be used
        else:
            self.controller.settings = settings

    @property
    def fingers(self) -> dict[str, GraspFinger]:
        """The fingers by name; none until the node is configured."""
        return {} if self.controller is None else self.controller.fingers

    def _begin_model_swap(self, before: ControlSettings, settings: ControlSettings) -> None:
        """When the fingertips are said to be others, build their estimators beside the loop."""
        swap = self._model_swap
        if swap is None or getattr(before, "tip", None) == getattr(settings, "tip", None):
            return
        self._make_estimator = swap.factory(settings)
        if self.fingers:
            swap.begin(settings, {name: finger.past for name, finger in self.fingers.items()})

    def _take_new_estimators(self) -> None:
        if self._model_swap is None:
            return
        if self._model_swap.refused:
            self.rejected["model refused"] = self._model_swap.refused
        successors = self._model_swap.take()
        for name, estimator in (successors or {}).items():
            if name in self.fingers:
                self._take_back([self.fingers[name]])
                self._batch = self._packets = None
                self._compiled.pop(name, None)  # its step is of the former model; to compile stops the loop
                self.fingers[name].replace_estimator(estimator)
                self.diagnoser.forget(name)

    def configure(self) -> None:
        """Build every finger and compile what will run."""
        self._forget_compiled()
        self.controller = GripController(
            self._names, settings=self.parameters, make_estimator=self._new_estimator,
            known_object=self._known_object,
        )  # fmt: skip
        self.controller.need_of = self._need
        if taken := describe_derived(self.parameters.grip, len(self._names)):
            logging.getLogger(f"vegrip.{self.name}").info("%s", taken)
        self._compile()

    def activate(self) -> None:
        """Begin afresh, except after a fault of this node: then the grip is taken over as it is."""
        self._take_back(self.fingers.values())
        if self.controller is not None and self._is_at_fault:
            self.controller.restart()
        elif self.controller is not None and self._worn:
            self._keep_what_was_learned()
            self._forget_compiled()
            self.controller.reset()
        self._compile()
        self._active, self._is_at_fault = True, False

    def deactivate(self) -> None:
        """Command no more."""
        self._take_back(self.fingers.values())
        self._active = False
        self._worn = True

    def cleanup(self) -> None:
        """Forget the fingers, but not what they learned."""
        self._take_back(self.fingers.values())
        self._keep_what_was_learned()
        self.controller = None
        self._forget_compiled()
        self._worn = False

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        """Answer a state of a known finger with its command, and what is due of the reports."""
        controller = self.controller
        if controller is None or not self._active or not isinstance(message, FingertipState):
            return ()
        finger = controller.fingers.get(message.finger)
        if finger is None:
            self.rejected["unknown finger"] += 1
            return ()
        self._take_back([finger])
        if controller.assimilate(message, now):
            self.diagnoser.note(finger.name, message, finger.estimator.in_contact)
        commands = controller.commands([finger.name], now)
        self._tell_needs()
        return chain(commands, self._reports(controller, finger, now))

    def on_tick(self, now: int) -> Iterable[Message]:
        """Watch for silence; renew commands before they expire."""
        controller = self.controller
        if controller is None or not self._active:
            return ()
        self._take_new_estimators()
        answers: list[Message] = []
        for finger in controller.fingers.values():
            if self._is_quiet(finger, now):
                continue
            self._take_back([finger])
            answers += controller.watch(finger.name, now)
            self._tell_needs()
            if finger.watchdog.condition > Condition.DEGRADED:
                answers += self._reports(controller, finger, now)
        return answers

    def on_broken(self, finger: str, now: int) -> None:
        """Tell the watchdog of ``finger``: the bus is there, but what it brings is not to be understood."""
        if finger in self.fingers:
            self._take_back([self.fingers[finger]])
            self.fingers[finger].watchdog.corrupt(now)

    def on_fault(self, now: int) -> Iterable[Message]:
        """Ride out a fault of this node itself, without the estimators."""
        self._is_at_fault = True
        self._take_back(self.fingers.values())
        commands = self.controller.ride_out(now) if self.controller is not None else []
        self._tell_needs()
        return commands

    # the short way: frames in, frames out

    @property
    def compiled_fingers(self) -> Mapping[str, CompiledFinger]:
        """The fingers whose frames run compiled."""
        return self._compiled

    @property
    def frame_fingers(self) -> tuple[str, ...]:
        """The fingers whose frames may run compiled."""
        return self._names

    def run_compiled(self, lines: Mapping[str, FingerLine], mode: str = "") -> None:
        """Answer the frames of ``lines`` compiled from now on, finger by finger, as far as that is possible.

        Args:
            lines: of the fingers whose frames will come by :meth:`on_frame`; none: all goes by messages.
            mode: what runs the step, see :func:`vegrip.grip.compiled.finger_module`.

        """
        self._take_back(self.fingers.values())
        self._lines, self._kernel_mode = lines, mode
        self._compile()

    def on_frame(
        self, name: str, frame: np.ndarray, length: int, arrival: int, now: int, part: int = 0
    ) -> int:
        """Answer a frame of the finger ``name``; see :meth:`CompiledFinger.step`.

        Where several frames make a state ``part`` is the number of this one, from 1. What is left alone is
        for :meth:`on_message`; for a finger without a compiled step everything is. The
        answer is :meth:`command_frame`, what is due besides :meth:`reports`.
        """
        compiled = self._lent(name)
        if compiled is None:
            return LEFT_ALONE
        if part:
            done = compiled.step_part(frame, length, part, arrival, now)
        else:
            done = compiled.step(frame, length, arrival, now)
        if done == LEFT_ALONE:
            self._take_back([compiled.finger])  # the objects answer, and refuse by name
        return done

    def on_values(self, name: str, values: Floats, counter: int, stamp: int, arrival: int, now: int) -> int:
        """Answer the values of a state of the finger ``name``; see :meth:`CompiledFinger.step_values`.

        As :meth:`on_frame`; the answer is :meth:`command_given`.
        """
        compiled = self._lent(name)
        if compiled is None:
            return LEFT_ALONE
        done = compiled.step_values(values, counter, stamp, arrival, now)
        if done == LEFT_ALONE:
            self._take_back([compiled.finger])  # the objects answer, and refuse by name
        return done

    def on_batch(self, payload: bytes, rows: int, arrival: int, now: int) -> tuple[bytearray, int] | None:
        """Answer the rows of a batch of states, see :meth:`CompiledBatch.step`; None: all are left alone.

        What is left alone is for :meth:`on_message`; the answer is :meth:`batch_commands`.
        """
        batch = self._batch
        if batch is None or not self._all_lent(batch.fingers):
            return None
        done, commands = batch.step(payload, rows, arrival, now)
        row = done.find(LEFT_ALONE, 0, rows)
        while row >= 0:
            if (refused := batch.finger_of(payload, row)) is not None:
                self._take_back([refused.finger])  # the objects answer, and refuse by name
            row = done.find(LEFT_ALONE, row + 1, rows)
        return done, commands

    @property
    def takes_packets(self) -> bool:
        """Whether :meth:`on_packet` answers."""
        return self._packets is not None

    def on_packet(self, packet: bytes, expected: int, now: int) -> PacketAnswer | None:
        """Answer the states at the beginning of a packet, see :meth:`CompiledPackets.step`; None: none.

        What is behind them, and what the step leaves alone, is for :meth:`on_frame`.
        """
        packets = self._packets
        if packets is None or not self._all_lent(packets.fingers):
            return None
        return packets.step(packet, expected, now)

    def report_packet(self, name: str, now: int) -> memoryview | None:
        """Return requests to send contact and slip margin, None where the compiled step cannot tell them."""
        packets = self._packets
        if not self._active or packets is None or not self._compiled[name].lent:
            return None
        return packets.report(name, now)

    @property
    def batch_commands(self) -> bytearray:
        """The rows of the commands that :meth:`on_batch` gave last, below a head that is still empty."""
        return bytearray() if self._batch is None else self._batch.commands

    def names_in(self, payload: bytes, rows: int) -> Sequence[str]:
        """Return whose states the rows of a batch are, "" for another one's."""
        return ("",) * rows if self._batch is None else self._batch.names_in(payload, rows)

    def command_frame(self, name: str) -> np.ndarray:
        """Return the bytes of the last command that :meth:`on_frame` gave."""
        return self._compiled[name].answer

    def reports(self, name: str, now: int) -> Iterator[Message]:
        """Return what is due to be told of a finger; worked out when it is taken."""
        controller = self.controller
        return iter(()) if controller is None else self._reports(controller, controller.fingers[name], now)

    def report_frames(self, name: str, now: int) -> Iterable[tuple[int, np.ndarray]]:
        """Return identifiers and frames of contact and slip margin, if the compiled step can tell them."""
        compiled = self._compiled.get(name)
        if not self._active or compiled is None or not compiled.lent or not compiled.tell(now):
            return ()
        return zip(compiled.report_ids, compiled.report_frames, strict=True)

    def report_batch(self, names: Sequence[str], now: int) -> list[str]:
        """Pack contacts and slip margins of fingers into :attr:`batch_reports`; return whose were told."""
        batch = self._batch
        if not self._active or batch is None:
            return []
        return batch.report([name for name in names if self._compiled[name].lent], now)

    @property
    def batch_reports(self) -> tuple[bytearray, bytearray]:
        """The rows that :meth:`report_batch` has packed last, below heads that are still empty."""
        batch = self._batch
        return (bytearray(), bytearray()) if batch is None else (batch.contacts, batch.margins)

    def has_more_to_tell(self, name: str, now: int) -> bool:
        """Return whether :meth:`reports` has something to tell besides :meth:`report_frames`."""
        compiled = self._compiled.get(name)
        return compiled is None or not compiled.lent or compiled.has_more_to_tell(now)

    def felt(self, name: str) -> tuple[float, float]:
        """Return normal force [N] and displacement [m] of the last frame that ran compiled."""
        return self._compiled[name].felt()

    def state_taken(self, name: str) -> Unmade:
        """Return the state of the last frame that ran compiled."""
        return self._compiled[name].state_taken()

    def command_given(self, name: str) -> Unmade:
        """Return the last command that was given compiled."""
        return self._compiled[name].command_given()

    def command_numbers(self, name: str) -> tuple[int, float, float, int, int]:
        """Return counter, force [N], its change [N], reason and lifetime [ns] of that command."""
        return self._compiled[name].command_numbers()

    def take_back(self, name: str = "") -> None:
        """Bring the objects up to date with what ran compiled, of the finger ``name`` or of all."""
        self._take_back([self.fingers[name]] if name else self.fingers.values())

    def read_counters(self) -> None:
        """Bring up to date what was counted of frames; what runs compiled goes on doing so.

        To take everything back for that, and to lend it again, would stop the loop for milliseconds.
        """
        for compiled in self._compiled.values():
            compiled.read_counters()

    def standing_commands(self) -> list[ForceCommand]:
        """Return the last command of each finger that has one."""
        self.take_back()
        controllers = [finger.controller for finger in self.fingers.values()]
        return [controller.standing_command() for controller in controllers if controller.started]

    def number_commands_from(self, numbers: Mapping[str, int]) -> None:
        """Give every next command a number above those that were sent in the node's place."""
        self.take_back()
        for name, number in numbers.items():
            if name in self.fingers:
                self.fingers[name].controller.number_from(number)

    def _lent(self, name: str) -> CompiledFinger | None:
        """Return the compiled finger ``name`` with all that it needs, None where the objects answer."""
        compiled, controller = self._compiled.get(name), self.controller
        if compiled is None or controller is None or not self._active:
            return None
        return compiled if compiled.lent or compiled.lend(controller, self._periods) else None

    def _all_lent(self, fingers: Iterable[CompiledFinger]) -> bool:
        """Return whether the compiled steps of all fingers have what they need."""
        controller = self.controller
        if controller is None or not self._active:
            return False
        return all(compiled.lent or compiled.lend(controller, self._periods) for compiled in fingers)

    def _forget_compiled(self) -> None:
        self._compiled, self._batch, self._packets = {}, None, None

    def _compile(self) -> None:
        """Prepare the compiled step of every finger that can have one, from the state of its objects."""
        controller, thumb = self.controller, self.parameters.thumb
        thumb_number = self._names.index(thumb) if thumb in self._names else -1
        if controller is not None:
            self._shared = controller.friction.shared
        self._shared[: len(self._names)] = np.nan
        self._compiled = {
            name: CompiledFinger(
                finger,
                self._lines[name],
                Place(self._names.index(name), len(self._names), thumb_number),
                self._shared,
                self._kernel_mode,
            )
            for name, finger in self.fingers.items()
            if name in self._lines and not why_not_compiled(finger, self.parameters)
        }
        fingers = list(self._compiled.values())
        is_whole = bool(fingers) and len(fingers) == len(self.fingers)
        self._batch = self._packets = None
        if is_whole and can_batch(fingers):
            self._batch = CompiledBatch(fingers, self._shared, STATE_BYTES)
        elif is_whole and can_take_packets(fingers):
            self._packets = CompiledPackets(fingers, self._shared)
        self._tell_needs()

    @property
    def path_taken(self) -> str:
        """How states are answered: by the compiled step or by objects, and why, in a sentence."""
        lifetime = self.parameters.limits.lifetime
        if self._lines and not all(line.carries(lifetime) for line in self._lines.values()):
            return (
                f"states are answered by objects: no frame can say that a command lives for {lifetime:g} s"
                " (limits.lifetime)"
            )
        if self._compiled and len(self._compiled) == len(self.fingers):
            compiled = next(iter(self._compiled.values()))
            how = "all fingers at once" if self._batch is not None else "finger by finger"
            return f"states are answered by the compiled step ({compiled.runs_by}), {how}"
        if not self._lines:
            return f"states are answered by objects: {WHY_NO_LINES}"
        reasons = {why_not_compiled(finger, self.parameters) for finger in self.fingers.values()} - {""}
        told = ", ".join(sorted(reasons)) or "a new model has been taken over"
        return (
            f"states are answered by objects ({len(self._compiled)} of {len(self.fingers)} compiled): {told}"
        )

    @property
    def _periods(self) -> tuple[float, float]:
        return self.parameters.report_period, self.parameters.health_period

    def _look(self, finger: GraspFinger) -> None:
        """Let the objects see the contact, whichever way it was followed."""
        compiled = self._compiled.get(finger.name)
        if compiled is not None and compiled.lent and (kept := compiled.look()) is not None:
            self.diagnoser.note_kept(kept)

    def _told(self, finger: GraspFinger) -> None:
        """Let the compiled step know what has been reported."""
        compiled = self._compiled.get(finger.name)
        if compiled is not None and compiled.lent:
            compiled.told(self._periods)

    def _take_back(self, fingers: Iterable[GraspFinger]) -> None:
        """Put the objects of these fingers in force."""
        for finger in fingers:
            compiled = self._compiled.get(finger.name)
            if compiled is not None and compiled.lent:
                self.diagnoser.note_kept(compiled.take_back())

    def _tell_needs(self) -> None:
        """Let the compiled fingers know what those need that the objects are in force of."""
        for number, (name, finger) in enumerate(self.fingers.items()):
            compiled = self._compiled.get(name)
            if compiled is None or not compiled.lent:
                self._shared[number] = need_of(finger)

    def _is_quiet(self, finger: GraspFinger, now: int) -> bool:
        compiled = self._compiled.get(finger.name)
        return compiled is not None and compiled.lent and compiled.is_quiet(now)

    def _need(self, finger: GraspFinger) -> float:
        compiled = self._compiled.get(finger.name)
        return compiled.need if compiled is not None and compiled.lent else need_of(finger)

    def _known_object(self) -> ObjectFriction | None:
        objects = self._known_objects()
        return None if objects is None else objects.read(self.parameters.friction.object)

    def _keep_what_was_learned(self) -> None:
        self._learned_store.save()
        objects = self._known_objects()
        found = self.controller.friction.learned_object if self.controller is not None else None
        if objects is not None and found is not None:
            objects.write(self.parameters.friction.object, found)

    def _known_objects(self) -> KnownObjects | None:
        """Return where the friction of objects is kept, None where no object is named."""
        name, folder = self.parameters.friction.object, getattr(self.parameters, "learned", "")
        if name and not folder:
            raise ConfigError(
                f"{self.name}: friction.object is {name!r}, but 'learned' names no folder to keep it in"
            )
        return KnownObjects(Path(folder)) if name else None

    def _new_estimator(self, finger: str) -> Estimator:
        return self._make_estimator(finger)  # another one after a change of the model

    def _reports(self, controller: GripController, finger: GraspFinger, now: int) -> Iterator[Message]:
        looks = finger.health_due(now, self.parameters.health_period)
        self._look(finger)
        for report in controller.reports(finger.name, now):
            self._told(finger)
            yield self._with_suspects(report, controller)
            self._look(finger)  # a frame that came meanwhile may have run compiled
        self._told(finger)
        if looks:
            self._tell_probing(controller)
            self._drive_log.tell(finger.name, controller.friction, self.parameters.grip)
        # last, so that a state that has come meanwhile need not wait for it
        if looks and (learned := self._learned_store.observe(finger.name, now)):
            yield from finger.learned_messages(learned, now, self.parameters.learned_period)

    def _with_suspects(self, report: Message, controller: GripController) -> Message:
        if isinstance(report, ContactEstimate):
            return controller.friction.state_friction(report)
        if not isinstance(report, ModelHealth):
            return report
        return controller.friction.name_suspect(self.diagnoser.annotate(report))

    def describe_finger(self, finger: str, channels: Collection[str]) -> str:
        """Return what ``finger`` grips by, and what it would take to grip less."""
        friction = self.controller.friction if self.controller is not None else None
        if friction is None or not {"tangential_force_x", "tangential_force_y"} <= {*channels}:
            return ""  # no load is known, so nothing is gripped by, which is said elsewhere
        by, less = "friction that is probed", friction.why_not_probing
        if not {"slip", "slip_speed"} & {*channels}:
            by, less = "the friction of its model", "it must feel slip, which no channel of it does"
        elif not friction.active:
            by = "friction that its own slides teach"
            less = "vegrip calibrate --launch, or connect --log, measures how it feels slip and has all learn"
        elif less:
            by = "friction that the slides of all fingers teach"
        return f"{finger} grips by {by}{f'; to grip less: {less}' if less else ''}"

    def _tell_probing(self, controller: GripController) -> None:
        """Log why friction is not probed, where that is asked for, and whenever it changes."""
        friction = controller.friction
        if not friction.active or not self.parameters.friction.probing:
            return
        why = friction.why_not_probing
        if why != self._why_not_probing:
            self._why_not_probing = why
            logger = logging.getLogger(f"vegrip.{self.name}")
            if why:
                logger.warning("friction is not probed: %s", why)
            else:
                logger.info("friction is probed again")
