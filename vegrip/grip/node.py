"""The node that grips: a grip controller with a lifecycle, on a bus."""

import logging
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from vegrip.config import build
from vegrip.errors import ConfigError, UsageError
from vegrip.grip.background_diagnosis import NoDiagnosis
from vegrip.grip.compiled_rows import CompiledBatch, CompiledPackets, PacketAnswer, join
from vegrip.grip.controller import GripController
from vegrip.grip.drive_log import DriveLog
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import GraspFinger
from vegrip.grip.frame_path import PATHS, FramePath
from vegrip.grip.grasp_action import GraspAction, GraspGoal, ReleaseGoal
from vegrip.grip.input_log import InputLog
from vegrip.grip.known_objects import KnownObjects, ObjectFriction
from vegrip.grip.learned_store import InMemory
from vegrip.grip.model_swap import ModelSwap
from vegrip.grip.safety import limit_not_stated
from vegrip.grip.settings import ControlSettings, make_share
from vegrip.grip.wires import COMMANDED, LEFT_ALONE, REPORT
from vegrip.host.realtime import NODE_PRIORITY
from vegrip.messages import (
    Condition,
    ContactEstimate,
    FingertipState,
    ForceCommand,
    GraspPhase,
    GraspStatus,
    Message,
    ModelHealth,
    NodeStatus,
)
from vegrip.runtime import NodeBase
from vegrip.runtime.node import OfLoop
from vegrip.transport.codec.frame_codec import Line

LETTING_GO = (GraspPhase.RELEASING, GraspPhase.RELEASED)


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
    received_messages: tuple[type[Message], ...] = (
        FingertipState,
        ForceCommand,
        NodeStatus,
    )  # also of rivals
    realtime_priority = NODE_PRIORITY

    def __init__(
        self,
        name: str,
        fingers: Sequence[str],
        make_estimator: Callable[[str], Estimator],
        settings: ControlSettings,
        learned_store: InMemory | None = None,
        model_swap: ModelSwap | None = None,
        diagnoser: NoDiagnosis | None = None,
    ) -> None:
        self.controller: GripController | None = None
        """What grips; None until the node is configured."""
        self._names = tuple(fingers)
        self._logger = logging.getLogger(f"vegrip.{name}")
        self._action = GraspAction(name, self._names, settings.thumb)
        self.limit_is_stated = True
        """Whether the launch file or a map states ``limits.max_force``; else it is said."""
        self._model_swap: ModelSwap | None = None
        self._lines: Mapping[str, Line] = {}
        self._kernel_mode = ""
        self.batch: CompiledBatch | None = None
        self.packets: CompiledPackets | None = None
        super().__init__(name, settings)
        self._make_estimator = make_estimator
        self._learned_store = learned_store or InMemory()
        self._model_swap = model_swap
        self.diagnoser = diagnoser or NoDiagnosis()
        self._active = False
        self._why_not_probing = ""  # as last reported
        self._drive_log, self._input_log = DriveLog(name), InputLog(name)
        self._worn = False  # the fingers have a past
        self._is_at_fault = False  # of this node itself, not of its input

    @property
    def parameters(self) -> ControlSettings:
        return self._parameters

    @parameters.setter
    def parameters(self, settings: ControlSettings) -> None:
        before = getattr(self, "_parameters", settings)
        if self.controller is None:
            make_share(settings, self._names)  # says now what cannot be used
        else:
            self.controller.settings = self._bounded(settings)
        self._parameters = settings
        self._begin_model_swap(before, settings)

    @property
    def fingers(self) -> dict[str, GraspFinger]:
        return {} if self.controller is None else self.controller.fingers

    def grasp(self, goal: Mapping[str, Any]) -> None:
        """Close around an object; :attr:`grasp_status` says how it goes.

        Raises:
            ConfigError: a goal that cannot be.
            UsageError: the node is not active.

        """
        self._require_active()
        self._action.grasp(build(GraspGoal, goal, "the goal of the grasp"))
        self._bound()

    def release(self, goal: Mapping[str, Any]) -> None:
        """Let the force down to zero; errors as of :meth:`grasp`."""
        self._require_active()
        self._action.release(build(ReleaseGoal, goal, "the release"), self.fingers)
        self._bound()

    def grasp_status(self, now: int) -> GraspStatus:
        return self._action.result(now)

    def _require_active(self) -> None:
        if not self._active:
            raise UsageError(f"{self.name} is not active; `vegrip lifecycle set {self.name} active`")

    def _bounded(self, settings: ControlSettings) -> ControlSettings:
        return replace(settings, limits=self._action.limits(settings.limits))

    def _bound(self) -> None:
        if self.controller is not None:
            self.controller.limit_watch.is_letting_go = self._action.phase in LETTING_GO
        if (
            self.controller is not None
            and (settings := self._bounded(self._parameters)).limits != self.controller.settings.limits
        ):
            self.controller.settings = settings

    def _begin_model_swap(self, before: ControlSettings, settings: ControlSettings) -> None:
        """When the fingertips are said to be others, build their estimators beside the loop."""
        swap = self._model_swap
        if swap is None or getattr(before, "tip", None) == getattr(settings, "tip", None):
            return
        self._make_estimator = swap.factory(settings)
        if self.fingers:
            swap.begin(settings, self.fingers)

    def _take_new_estimators(self) -> None:
        if self._model_swap is None:
            return
        if self._model_swap.refused:
            self.rejected["model refused"] = self._model_swap.refused
        successors = self._model_swap.take()
        for name, (estimator, module) in (successors or {}).items():
            if name in self.fingers:
                self.fingers[name].numbers.replace_estimator(estimator, module)
                self.diagnoser.forget(name)
        if successors:
            self._join()

    def configure(self) -> None:
        """Build every finger and compile what will run."""
        self.controller = GripController(
            self._names, settings=self._bounded(self._parameters), make_estimator=self._new_estimator,
            known_object=self._known_object,
        )  # fmt: skip
        if not self.limit_is_stated:
            self._logger.warning(
                "%s, in the launch file or in [limits] of a map", limit_not_stated(self._parameters.limits)
            )
        self.run_compiled(self._lines, self._kernel_mode)

    def activate(self) -> None:
        self.leave_lines()
        if not self._is_at_fault:
            self._action = GraspAction(self.name, self._names, self._parameters.thumb)
            self._bound()
        if self.controller is not None and self._is_at_fault:
            self.controller.restart()
        elif self.controller is not None and self._worn:
            self._keep_what_was_learned()
            self.controller.reset()
        self._join()
        self._active, self._is_at_fault = True, False

    def deactivate(self) -> None:
        self.leave_lines()
        self._active = False
        self._worn = True

    def cleanup(self) -> None:
        """Forget the fingers, but not what they learned."""
        self.leave_lines()
        self._keep_what_was_learned()
        self.controller = self.batch = self.packets = None
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
        done = finger.answer(message, now) if finger.is_whole else controller.answer(message, now)
        commands = (finger.command(),) if done & COMMANDED else ()
        return chain(commands, self._reports(controller, finger, now)) if done & REPORT else commands

    def on_tick(self, now: int) -> Iterable[Message]:
        """Watch for silence; renew commands before they expire."""
        controller = self.controller
        if controller is None or not self._active:
            return ()
        self._take_new_estimators()
        answers: list[Message] = []
        for finger in controller.fingers.values():
            if finger.is_quiet(now):
                continue
            answers += controller.watch(finger.name, now)
            if finger.condition > Condition.DEGRADED:
                answers += self._reports(controller, finger, now)
        if self._action.look(controller.fingers, now):
            self._bound()
        if (status := self._action.status(now)) is not None:
            answers.append(status)
        return answers

    def on_broken(self, finger: str, now: int) -> None:
        """Inform the watchdog of ``finger``: the bus is there, but what it brings is not to be understood."""
        if finger in self.fingers:
            self.fingers[finger].note_broken(now)

    def on_fault(self, now: int) -> Iterable[Message]:
        """Hold the last commands through a fault of this node itself, without the estimators."""
        self._is_at_fault = True
        return self.controller.hold_last(now) if self.controller is not None else []

    # the short way: frames in, frames out

    def frame_path(self, endpoint: Any, loop: OfLoop) -> FramePath:
        return PATHS[endpoint.brings](self, endpoint, loop)

    @property
    def compiled_fingers(self) -> Mapping[str, GraspFinger]:
        return {
            name: finger for name, finger in self.fingers.items() if finger.numbers.line and finger.is_whole
        }

    def run_compiled(self, lines: Mapping[str, Line], mode: str = "") -> None:
        """Answer the frames of ``lines`` compiled from now on, finger by finger, as far as that is possible.

        Args:
            lines: of the fingers whose frames will come by :meth:`on_frame`; none: all goes by messages.
            mode: what runs the step, see :func:`vegrip.grip.compiled.finger_module`.

        """
        self._lines, self._kernel_mode = lines, mode
        if self.controller is not None:
            self.controller.follow_lines(lines, mode)
        self._join()

    def on_frame(self, name: str, frame: np.ndarray, length: int, arrival: int, now: int) -> int:
        """Answer a frame of the finger ``name``; see :meth:`GraspFinger.step`.

        What is left alone is for :meth:`on_message`; for a finger in which Python takes part everything is.
        The answer is :attr:`FingerStep.answer_frame`, what is due besides :meth:`reports`.
        """
        finger = self._on_line(name)
        if finger is None:
            return LEFT_ALONE
        done = finger.step(frame, length, arrival, now)
        if done == LEFT_ALONE:
            finger.numbers.leave_line()  # the codec decodes it, or refuses by name
        return done

    def on_batch(self, payload: bytes, rows: int, arrival: int, now: int) -> tuple[bytearray, int] | None:
        """Answer the rows of a batch of states, see :meth:`CompiledBatch.step`; None: all are left alone.

        What is left alone is for :meth:`on_message`; the answer stands in :attr:`CompiledBatch.commands`.
        """
        batch = self.batch
        if batch is None or not self._are_on_line(batch.fingers):
            return None
        done, commands = batch.step(payload, rows, arrival, now)
        row = done.find(LEFT_ALONE, 0, rows)
        while row >= 0:
            if (refused := batch.finger_of(payload, row)) is not None:
                refused.numbers.leave_line()  # the codec decodes it, or refuses by name
            row = done.find(LEFT_ALONE, row + 1, rows)
        return done, commands

    def on_packet(self, packet: bytes, expected: int, now: int) -> PacketAnswer | None:
        """Answer the states at the beginning of a packet, see :meth:`CompiledPackets.step`; None: none.

        What is behind them, and what the step leaves alone, is for :meth:`on_frame`.
        """
        packets = self.packets
        if packets is None or not self._are_on_line(packets.fingers):
            return None
        return packets.step(packet, expected, now)

    def reports(self, name: str, now: int) -> Iterator[Message]:
        """Return what is due to be reported of a finger; worked out when it is taken."""
        controller = self.controller
        return iter(()) if controller is None else self._reports(controller, controller.fingers[name], now)

    def leave_lines(self, name: str = "") -> None:
        for finger in [self.fingers[name]] if name else self.fingers.values():
            finger.numbers.leave_line()

    def standing_commands(self) -> list[ForceCommand]:
        return [finger.standing_command() for finger in self.fingers.values() if finger.started]

    def _on_line(self, name: str) -> GraspFinger | None:
        finger = self.fingers.get(name)
        return finger if finger is not None and self._active and finger.take_line() else None

    def _are_on_line(self, fingers: Iterable[GraspFinger]) -> bool:
        return self._active and all(finger.numbers.is_on_line or finger.take_line() for finger in fingers)

    def _join(self) -> None:
        fingers = list(self.compiled_fingers.values())
        is_whole = bool(fingers) and len(fingers) == len(self.fingers)
        self.batch = self.packets = None
        if is_whole and self.controller is not None:
            joined = join(fingers, self.controller.friction.memory.array)
            self.batch = joined if isinstance(joined, CompiledBatch) else None
            self.packets = joined if isinstance(joined, CompiledPackets) else None

    @property
    def path_taken(self) -> str:
        """How states are answered, and why, in a sentence."""
        fingers, lifetime = list(self.fingers.values()), self.parameters.limits.lifetime
        if not fingers:
            return "no finger is configured"
        way = f"states are answered by the compiled step ({fingers[0].numbers.runs_by})"
        if not self._lines:
            return (
                f"{way}, as messages: one does not come in one CAN FD frame of our own layout, or comes in"
                " restored order (order_window) or by the hand's clock (estimate_clock)"
            )
        if not all(line.carries(lifetime) for line in self._lines.values()):
            return (
                f"{way}, as messages: no frame can say that a command lives for {lifetime:g} s"
                " (limits.lifetime)"
            )
        if reasons := sorted({finger.why_split for finger in fingers} - {""}):
            return f"{way}, in halves: {', '.join(reasons)}"
        return f"{way}, {'all fingers at once' if self.batch is not None else 'finger by finger'}"

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
        name, folder = self.parameters.friction.object, getattr(self.parameters, "learned", "")
        if name and not folder:
            raise ConfigError(
                f"{self.name}: friction.object is {name!r}, but 'learned' names no folder to keep it in"
            )
        return KnownObjects(Path(folder)) if name else None

    def _new_estimator(self, finger: str) -> Estimator:
        return self._make_estimator(finger)  # another one after a change of the model

    def _reports(self, controller: GripController, finger: GraspFinger, now: int) -> Iterator[Message]:
        looks = finger.reports.health_due(now)
        self._note_past(finger)
        for report in controller.reports(finger.name, now):
            if isinstance(report, ModelHealth):
                self._input_log.log_changes(report, is_periodic=looks)
            yield self._with_suspects(report, controller)
        if looks:
            controller.limit_watch.log_changes(self._logger, controller.settings.limits.max_force)
            self._log_probing(controller)
            self._drive_log.log_changes(finger.name, controller.friction, self.parameters.grip)
        # last, so that a state that has come meanwhile need not wait for it
        if looks and (learned := self._learned_store.observe(finger.name, now)):
            yield from finger.reports.learned(learned, now)

    def _note_past(self, finger: GraspFinger) -> None:
        if (kept := finger.numbers.fetch()) is not None:
            self.diagnoser.note(kept)

    def _with_suspects(self, report: Message, controller: GripController) -> Message:
        if isinstance(report, ContactEstimate):
            return controller.friction.state_friction(report)
        if not isinstance(report, ModelHealth):
            return report
        return controller.friction.report_unsound(self.diagnoser.annotate(report))

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

    def _log_probing(self, controller: GripController) -> None:
        """Log why friction is not probed, where that is asked for, and whenever it changes."""
        friction = controller.friction
        if not friction.active:
            return
        why = friction.why_not_probing
        if why != self._why_not_probing:
            self._why_not_probing = why
            if why:
                self._logger.warning("friction is not probed: %s", why)
            else:
                self._logger.info("friction is probed again")
