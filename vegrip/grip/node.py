"""The node that grips: any number of fingers, each with its own estimator, watchdog and controller."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain

from vegrip.grip.background_diagnosis import Nobody, Suspects
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import UNUSED, GraspFinger, Wanted
from vegrip.grip.finger_controller import FingerController
from vegrip.grip.joint_confidence import each_confidence
from vegrip.grip.learned_store import Memory, Nothing
from vegrip.grip.model_swap import Succession
from vegrip.grip.safety.fail_safe import FailSafe
from vegrip.grip.safety.watchdog import InputWatchdog
from vegrip.grip.settings import ControlSettings, make_policy, make_share
from vegrip.grip.warm_up import dummy_states
from vegrip.messages import Condition, FingertipState, ForceCommand, Message, ModelHealth
from vegrip.runtime import NodeBase


class GraspForce(NodeBase):
    """FingertipState in; ForceCommand, ContactEstimate, SlipMargin, ModelHealth, LearnedParameter out.

    The command comes first of every answer, because it is the one that is waited for. The reports are worked
    out when they are taken.

    Args:
        name: of the node.
        fingers: names of the fingers; states of others are counted in :attr:`rejected` and ignored.
        make_estimator: gives a new estimator for a finger; called by :meth:`configure`.
        settings: how the grasp is controlled.
        succession: builds new estimators when parameters of the fingertips change while the node runs.
        suspects: looks for what is behind a model that fails.
        memory: of what the fingers learn; asked to keep it by :meth:`cleanup`, when nothing is held.

    """

    alone: tuple[type[Message], ...] = (ForceCommand,)

    def __init__(
        self,
        name: str,
        fingers: Sequence[str],
        make_estimator: Callable[[str], Estimator],
        settings: ControlSettings,
        memory: Memory | None = None,
        succession: Succession | None = None,
        suspects: Suspects | None = None,
    ) -> None:
        self.fingers: dict[str, GraspFinger] = {}
        self._names = tuple(fingers)
        self._succession: Succession | None = None
        super().__init__(name, settings)
        self._make_estimator = make_estimator
        self._memory = memory or Nothing()
        self._succession = succession
        self.suspects = suspects or Nobody()
        self._active = False
        self._worn = False  # the fingers have a past
        self._at_fault = False  # of this node itself, not of its input

    @property
    def parameters(self) -> ControlSettings:
        """What can be changed while the node runs."""
        return self._parameters

    @parameters.setter
    def parameters(self, settings: ControlSettings) -> None:
        before = getattr(self, "_parameters", settings)
        self._parameters = settings
        self._remodel(before, settings)
        self._shared = make_share(settings, self._names)
        for finger in self.fingers.values():
            finger.apply(settings)

    def _remodel(self, before: ControlSettings, settings: ControlSettings) -> None:
        """When the fingertips are said to be others, build their estimators beside the loop."""
        succession = self._succession
        if succession is None or getattr(before, "tip", None) == getattr(settings, "tip", None):
            return
        self._make_estimator = succession.factory(settings)
        if self.fingers:
            succession.begin(settings, {name: finger.past for name, finger in self.fingers.items()})

    def _hand_over(self) -> None:
        if self._succession is None:
            return
        if self._succession.refused:
            self.rejected["model refused"] = self._succession.refused
        successors = self._succession.take()
        for name, estimator in (successors or {}).items():
            if name in self.fingers:
                self.fingers[name].succeed(estimator)
                self.suspects.forget(name)

    def configure(self) -> None:
        """Build every finger, and compile what will run by running it on fingers that are thrown away."""
        self.fingers = {name: self._finger(name) for name in self._names}
        for finger in self.fingers.values():
            for state in dummy_states(finger.name):
                finger.sense(state, state.stamp, self._wanted)
                finger.command(self._share(finger), state.stamp)
                list(finger.reports(state.stamp, 0.0, 0.0))
        self.fingers = {name: self._finger(name) for name in self._names}

    def activate(self) -> None:
        """Begin afresh, except after a fault of this node: then the grip is taken over as it is."""
        if self._at_fault:
            for finger in self.fingers.values():
                finger.restart()
        elif self._worn:
            self._memory.keep()
            self.fingers = {name: self._finger(name) for name in self._names}
        self._active, self._at_fault = True, False

    def deactivate(self) -> None:
        """Command no more."""
        self._active = False
        self._worn = True

    def cleanup(self) -> None:
        """Forget the fingers, but not what they learned."""
        self._memory.keep()
        self.fingers = {}
        self._worn = False

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        """Answer a state of a known finger with its command, and what is due of the reports."""
        if not self._active or not isinstance(message, FingertipState):
            return ()
        finger = self.fingers.get(message.finger)
        if finger is None:
            self.rejected["unknown finger"] += 1
            return ()
        finger.sense(message, now, self._wanted)
        if finger.past and finger.past[-1] is message:  # it was believed
            self.suspects.note(finger.name, message, finger.estimator.in_contact)
        return chain(self._commands([finger], now), self._reports(finger, now))

    def on_tick(self, now: int) -> Iterable[Message]:
        """Watch for silence; renew commands before they expire."""
        if not self._active:
            return ()
        self._hand_over()
        answers: list[Message] = []
        for finger in self.fingers.values():
            finger.watch(now)
            if finger.controller.due(now):
                answers += self._commands([finger], now)
            if finger.watchdog.condition > Condition.DEGRADED:
                answers += self._reports(finger, now)
        return answers

    def on_broken(self, finger: str, now: int) -> None:
        """Tell the watchdog of ``finger``: the bus is there, but what it brings is not to be understood."""
        if finger in self.fingers:
            self.fingers[finger].watchdog.corrupt(now)

    def on_fault(self, now: int) -> Iterable[Message]:
        """Ride out a fault of this node itself, without the estimators."""
        self._at_fault = True
        due = [finger for finger in self.fingers.values() if finger.controller.due(now)]
        for finger in due:
            finger.controller.want(Condition.STALE, UNUSED, now)
        return self._commands(due, now)

    def _finger(self, name: str) -> GraspFinger:
        settings = self.parameters
        controller = FingerController(
            name, make_policy(settings), FailSafe(settings.fail_safe), settings.limits
        )
        phase = self._names.index(name) / len(self._names)
        watchdog = InputWatchdog(settings.watchdog)
        return GraspFinger(name, self._make_estimator(name), controller, watchdog, phase)

    def _commands(self, fingers: Iterable[GraspFinger], now: int) -> list[ForceCommand]:
        return [finger.command(self._share(finger), now) for finger in fingers if finger.controller.started]

    @property
    def _wanted(self) -> Wanted:
        """Margin and confidence of each finger; all count, also those that are not heard."""
        grip = self.parameters.grip
        return grip.wanted_margin, each_confidence(grip.probability, len(self._names), grip.correlation)

    def _share(self, finger: GraspFinger) -> float:
        started = {f.name: f.controller.need for f in self.fingers.values() if f.controller.started}
        return self._shared(started).get(finger.name, 0.0)

    def _reports(self, finger: GraspFinger, now: int) -> Iterator[Message]:
        looks = finger.health_due(now, self.parameters.health_period)
        for report in finger.reports(now, self.parameters.report_period, self.parameters.health_period):
            yield self.suspects.judged(report) if isinstance(report, ModelHealth) else report
        # last, so that a state that has come meanwhile need not wait for it
        if looks and (learned := self._memory.look(finger.name, now)):
            yield from finger.lessons(learned, now, self.parameters.learned_period)
