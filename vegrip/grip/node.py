"""The node that grips: any number of fingers, each with its own estimator, watchdog and controller."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain

import numpy as np

from vegrip.grip.background_diagnosis import MisfitDiagnoser, NoDiagnosis
from vegrip.grip.compiled_finger import LEFT_ALONE, CompiledFinger, Place, can_compile
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import UNTRUSTED_DEMAND, GraspFinger, Wanted
from vegrip.grip.finger_controller import FingerController
from vegrip.grip.joint_confidence import each_confidence
from vegrip.grip.learned_store import LearnedStore, NoStore
from vegrip.grip.model_swap import ModelSwap
from vegrip.grip.safety.fail_safe import FailSafe
from vegrip.grip.safety.watchdog import InputWatchdog
from vegrip.grip.settings import ControlSettings, make_policy, make_share
from vegrip.grip.warm_up import dummy_states
from vegrip.messages import Condition, FingertipState, ForceCommand, Message, ModelHealth
from vegrip.runtime import NodeBase
from vegrip.transport.codec.line import Line


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
        self.fingers: dict[str, GraspFinger] = {}
        self._names = tuple(fingers)
        self._model_swap: ModelSwap | None = None
        self._compiled: dict[str, CompiledFinger] = {}
        self._lines: Mapping[str, Line] = {}
        self._kernel_mode = ""
        self._needs = np.full(max(1, len(self._names)), np.nan)
        super().__init__(name, settings)
        self._make_estimator = make_estimator
        self._learned_store = learned_store or NoStore()
        self._model_swap = model_swap
        self.diagnoser = diagnoser or NoDiagnosis()
        self._active = False
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
        self._shared = make_share(settings, self._names)
        for finger in self.fingers.values():
            finger.apply(settings)

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
                self._compiled.pop(
                    name, None
                )  # its step is of the former model; compiling would stop the loop
                self.fingers[name].replace_estimator(estimator)
                self.diagnoser.forget(name)

    def configure(self) -> None:
        """Build every finger, and compile what will run by running it on fingers that are thrown away."""
        self.fingers = {name: self._finger(name) for name in self._names}
        for finger in self.fingers.values():
            for state in dummy_states(finger.name):
                finger.sense(state, state.stamp, self.wanted)
                finger.command(self._share(finger), state.stamp)
                list(finger.reports(state.stamp, 0.0, 0.0))
        self.fingers = {name: self._finger(name) for name in self._names}
        self._compile()

    def activate(self) -> None:
        """Begin afresh, except after a fault of this node: then the grip is taken over as it is."""
        self._take_back(self.fingers.values())
        if self._is_at_fault:
            for finger in self.fingers.values():
                finger.restart()
        elif self._worn:
            self._learned_store.save()
            self.fingers = {name: self._finger(name) for name in self._names}
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
        self._learned_store.save()
        self.fingers, self._compiled = {}, {}
        self._worn = False

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        """Answer a state of a known finger with its command, and what is due of the reports."""
        if not self._active or not isinstance(message, FingertipState):
            return ()
        finger = self.fingers.get(message.finger)
        if finger is None:
            self.rejected["unknown finger"] += 1
            return ()
        self._take_back([finger])
        finger.sense(message, now, self.wanted)
        if finger.past and finger.past[-1] is message:  # it was believed
            self.diagnoser.note(finger.name, message, finger.estimator.in_contact)
        return chain(self._commands([finger], now), self._reports(finger, now))

    def on_tick(self, now: int) -> Iterable[Message]:
        """Watch for silence; renew commands before they expire."""
        if not self._active:
            return ()
        self._take_new_estimators()
        answers: list[Message] = []
        for finger in self.fingers.values():
            if self._is_quiet(finger, now):
                continue
            self._take_back([finger])
            finger.watch(now)
            if finger.controller.due(now):
                answers += self._commands([finger], now)
            if finger.watchdog.condition > Condition.DEGRADED:
                answers += self._reports(finger, now)
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
        due = [finger for finger in self.fingers.values() if finger.controller.due(now)]
        for finger in due:
            finger.controller.update(Condition.STALE, UNTRUSTED_DEMAND, now)
        return self._commands(due, now)

    # the short way: frames in, frames out

    @property
    def compiled_fingers(self) -> Mapping[str, CompiledFinger]:
        """The fingers whose frames run compiled."""
        return self._compiled

    @property
    def frame_fingers(self) -> tuple[str, ...]:
        """The fingers whose frames may run compiled."""
        return self._names

    def run_compiled(self, lines: Mapping[str, Line], mode: str = "") -> None:
        """Answer the frames of ``lines`` compiled from now on, finger by finger, as far as that is possible.

        Args:
            lines: of the fingers whose frames will come by :meth:`on_frame`; none: all goes by messages.
            mode: what runs the step, see :func:`vegrip.grip.compiled.finger_module`.

        """
        self._take_back(self.fingers.values())
        self._lines, self._kernel_mode = lines, mode
        self._compile()

    def on_frame(self, name: str, frame: np.ndarray, length: int, arrival: int, now: int) -> int:
        """Answer a frame of the finger ``name``; see :meth:`CompiledFinger.step`.

        What is left alone is for :meth:`on_message`; for a finger without a compiled step everything is. The
        answer is :meth:`command_frame`, what is due besides :meth:`reports`.
        """
        compiled = self._compiled.get(name)
        if compiled is None or not self._active:
            return LEFT_ALONE
        if not compiled.lent and not compiled.lend(self.wanted[1], self._periods):
            return LEFT_ALONE
        done = compiled.step(frame, length, arrival, now)
        if done == LEFT_ALONE:
            self._take_back([compiled.finger])  # the objects answer, and refuse by name
        return done

    def command_frame(self, name: str) -> np.ndarray:
        """Return the bytes of the last command that :meth:`on_frame` gave."""
        return self._compiled[name].answer

    def reports(self, name: str, now: int) -> Iterator[Message]:
        """Return what is due to be told of a finger; worked out when it is taken."""
        return self._reports(self.fingers[name], now)

    def felt(self, name: str) -> tuple[float, float]:
        """Return normal force [N] and displacement [m] of the last frame that ran compiled."""
        return self._compiled[name].felt()

    def take_back(self, name: str = "") -> None:
        """Bring the objects up to date with what ran compiled, of the finger ``name`` or of all."""
        self._take_back([self.fingers[name]] if name else self.fingers.values())

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

    def _compile(self) -> None:
        settings, thumb = self.parameters, self.parameters.thumb
        thumb_number = self._names.index(thumb) if thumb in self._names else -1
        self._needs[:] = np.nan
        self._compiled = {
            name: CompiledFinger(
                finger,
                self._lines[name],
                Place(self._names.index(name), len(self._names), thumb_number),
                self._needs,
                self._kernel_mode,
            )
            for name, finger in self.fingers.items()
            if name in self._lines and can_compile(finger, settings)
        }
        self._tell_needs()

    @property
    def _periods(self) -> tuple[float, float]:
        return self.parameters.report_period, self.parameters.health_period

    def _look(self, finger: GraspFinger) -> None:
        """Let the objects see the contact, whichever way it was followed."""
        compiled = self._compiled.get(finger.name)
        if compiled is not None and compiled.lent:
            for state, touching in compiled.look():
                self.diagnoser.note(finger.name, state, touching)

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
                for state, touching in compiled.take_back():
                    self.diagnoser.note(finger.name, state, touching)

    def _tell_needs(self) -> None:
        """Let the compiled fingers know what those need that the objects are in force of."""
        for number, (name, finger) in enumerate(self.fingers.items()):
            compiled = self._compiled.get(name)
            if compiled is None or not compiled.lent:
                self._needs[number] = _need_of(finger)

    def _is_quiet(self, finger: GraspFinger, now: int) -> bool:
        compiled = self._compiled.get(finger.name)
        return compiled is not None and compiled.lent and compiled.is_quiet(now)

    def _need(self, finger: GraspFinger) -> float:
        compiled = self._compiled.get(finger.name)
        return compiled.need if compiled is not None and compiled.lent else _need_of(finger)

    def _finger(self, name: str) -> GraspFinger:
        settings = self.parameters
        controller = FingerController(
            name, make_policy(settings), FailSafe(settings.fail_safe), settings.limits
        )
        phase = self._names.index(name) / len(self._names)
        watchdog = InputWatchdog(settings.watchdog)
        return GraspFinger(name, self._make_estimator(name), controller, watchdog, phase)

    def _commands(self, fingers: Iterable[GraspFinger], now: int) -> list[ForceCommand]:
        commands = [
            finger.command(self._share(finger), now) for finger in fingers if finger.controller.started
        ]
        self._tell_needs()
        return commands

    @property
    def wanted(self) -> Wanted:
        """Margin and confidence of each finger; all count, also those that are not heard."""
        grip = self.parameters.grip
        return grip.wanted_margin, each_confidence(grip.probability, len(self._names), grip.correlation)

    def _share(self, finger: GraspFinger) -> float:
        needs = {other.name: self._need(other) for other in self.fingers.values()}
        started = {name: need for name, need in needs.items() if not math.isnan(need)}
        return self._shared(started).get(finger.name, 0.0)

    def _reports(self, finger: GraspFinger, now: int) -> Iterator[Message]:
        looks, periods = finger.health_due(now, self.parameters.health_period), self._periods
        self._look(finger)
        for report in finger.reports(now, *periods):
            self._told(finger)
            yield self.diagnoser.annotate(report) if isinstance(report, ModelHealth) else report
            self._look(finger)  # a frame that came meanwhile may have run compiled
        self._told(finger)
        # last, so that a state that has come meanwhile need not wait for it
        if looks and (learned := self._learned_store.observe(finger.name, now)):
            yield from finger.learned_messages(learned, now, self.parameters.learned_period)


def _need_of(finger: GraspFinger) -> float:
    """Return what a finger needs [N], as its objects have it; NaN without a command."""
    return finger.controller.required_force if finger.controller.started else math.nan
