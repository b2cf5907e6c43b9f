"""The node that grips: a grip controller with a lifecycle, on a bus."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain

from vegrip.grip.background_diagnosis import MisfitDiagnoser, NoDiagnosis
from vegrip.grip.controller import GripController
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import GraspFinger
from vegrip.grip.learned_store import LearnedStore, NoStore
from vegrip.grip.model_swap import ModelSwap
from vegrip.grip.settings import ControlSettings, make_share
from vegrip.host.realtime import NODE_PRIORITY
from vegrip.messages import Condition, FingertipState, ForceCommand, Message, ModelHealth, NodeStatus
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
                self.fingers[name].replace_estimator(estimator)
                self.diagnoser.forget(name)

    def configure(self) -> None:
        """Build every finger and compile what will run."""
        self.controller = GripController(
            self._names, settings=self.parameters, make_estimator=self._new_estimator
        )

    def activate(self) -> None:
        """Begin afresh, except after a fault of this node: then the grip is taken over as it is."""
        if self.controller is not None and self._is_at_fault:
            self.controller.restart()
        elif self.controller is not None and self._worn:
            self._learned_store.save()
            self.controller.reset()
        self._active, self._is_at_fault = True, False

    def deactivate(self) -> None:
        """Command no more."""
        self._active = False
        self._worn = True

    def cleanup(self) -> None:
        """Forget the fingers, but not what they learned."""
        self._learned_store.save()
        self.controller = None
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
        if controller.assimilate(message, now):
            self.diagnoser.note(finger.name, message, finger.estimator.in_contact)
        return chain(controller.commands([finger.name], now), self._reports(controller, finger, now))

    def on_tick(self, now: int) -> Iterable[Message]:
        """Watch for silence; renew commands before they expire."""
        controller = self.controller
        if controller is None or not self._active:
            return ()
        self._take_new_estimators()
        answers: list[Message] = []
        for finger in controller.fingers.values():
            answers += controller.watch(finger.name, now)
            if finger.watchdog.condition > Condition.DEGRADED:
                answers += self._reports(controller, finger, now)
        return answers

    def on_broken(self, finger: str, now: int) -> None:
        """Tell the watchdog of ``finger``: the bus is there, but what it brings is not to be understood."""
        if finger in self.fingers:
            self.fingers[finger].watchdog.corrupt(now)

    def on_fault(self, now: int) -> Iterable[Message]:
        """Ride out a fault of this node itself, without the estimators."""
        self._is_at_fault = True
        return self.controller.ride_out(now) if self.controller is not None else ()

    def _new_estimator(self, finger: str) -> Estimator:
        return self._make_estimator(finger)  # another one after a change of the model

    def _reports(self, controller: GripController, finger: GraspFinger, now: int) -> Iterator[Message]:
        looks = finger.health_due(now, self.parameters.health_period)
        for report in controller.reports(finger.name, now):
            yield self.diagnoser.annotate(report) if isinstance(report, ModelHealth) else report
        # last, so that a state that has come meanwhile need not wait for it
        if looks and (learned := self._learned_store.observe(finger.name, now)):
            yield from finger.learned_messages(learned, now, self.parameters.learned_period)
