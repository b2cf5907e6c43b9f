"""Grip control of a hand without a bus: fingertip states in, force commands out. Public.

::

    hand = vegrip.GripController(("thumb", "index"), model=vegrip.paper_model(tip_radius=9e-3))
    commands = hand.step(states, now)  # in your own loop
    hand.margin("thumb").lower_bound

It has all that stands between a state and a command: estimator, watchdog of the input, grip policy, balance
of the grasp, fail-safe, limits, renewal of commands before they expire. The node on a bus
(:class:`~vegrip.grip.node.GraspForce`) is this controller with a lifecycle around it.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from vegrip.errors import UsageError
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import UNTRUSTED_DEMAND, GraspFinger, Wanted
from vegrip.grip.finger_controller import FingerController
from vegrip.grip.grasp_friction import share_friction
from vegrip.grip.joint_confidence import each_confidence
from vegrip.grip.known_objects import ObjectFriction
from vegrip.grip.safety.fail_safe import FailSafe
from vegrip.grip.safety.watchdog import InputWatchdog
from vegrip.grip.settings import ControlSettings, make_policy, make_share
from vegrip.grip.slip_table import derive_grip
from vegrip.grip.warm_up import dummy_states
from vegrip.messages import (
    Condition,
    ContactEstimate,
    FingertipState,
    ForceCommand,
    Message,
    ModelHealth,
    SlipMargin,
)
from vegrip.model import ContactModel
from vegrip.spelling import suggestion

REPORT_GROUPS = 5
"""Fingers that report at different times; of more, some report together, in one message where that is so."""

_WARM: set[str] = set()
"""Of controllers that have warmed up in this process: settings and number of fingers."""

MakeEstimator = Callable[[str], Estimator]
"""Gives a new estimator for the finger of this name."""


class GripController:
    """Grip control of any number of fingers that hold one object.

    Nothing here raises once it is built, whatever the states contain. Time comes in as ``now`` [ns] of a
    monotonic clock, the one that stamps the states.

    Args:
        fingers: their names.
        model: of every fingertip, or of each by its name.
        noise: of the sensors; the default is that of :class:`~vegrip.estimator.SensorNoise`.
        settings: how the grasp is controlled.
        estimator: how the estimators behave.
        make_estimator: gives the estimator of a finger, instead of ``model``, ``noise`` and ``estimator``.
        known_object: gives what former grasps have learned of the object, asked at every beginning; see
            :attr:`vegrip.grip.grasp_friction.GraspFriction.learned_object`.

    Raises:
        UsageError: there is neither a model nor ``make_estimator``, or a finger without a model.
        ConfigError: the settings cannot be used.
        ModelError: a model cannot be compiled.

    """

    def __init__(
        self,
        fingers: Sequence[str],
        model: ContactModel | Mapping[str, ContactModel] | None = None,
        noise: SensorNoise | None = None,
        settings: ControlSettings | None = None,
        *,
        estimator: EstimatorSettings | None = None,
        make_estimator: MakeEstimator | None = None,
        known_object: Callable[[], ObjectFriction | None] = lambda: None,
    ) -> None:
        self.names = tuple(fingers)
        self.rejected: Counter[str] = Counter()
        """States that were not for a finger of this hand, counted by name."""
        self._make_estimator = make_estimator or _from_models(self.names, model, noise, estimator)
        self._settings = self._derived(settings or ControlSettings())
        self._known_object = known_object
        self._share_of = make_share(self._settings, self.names)
        self.need_of: Callable[[GraspFinger], float] = need_of
        """Says what a finger needs [N], NaN without a command, to share the grasp by; :func:`need_of`."""
        self._now = 0  # [ns] of the last step
        self.fingers: dict[str, GraspFinger] = {}
        self.reset()
        self._warm_up()

    def step(self, states: Iterable[FingertipState], now: int) -> list[ForceCommand]:
        """Take the states that arrived at ``now`` [ns]; return the commands that are to be sent.

        One command for each finger of which a state came, and one for each whose last command would else
        expire: call it also when nothing came. A finger is commanded from its first state on.
        """
        self._now = max(self._now, now)
        heard: dict[str, None] = {}
        for state in states:
            if state.finger in self.fingers:
                self.assimilate(state, now)
                heard[state.finger] = None
            else:
                self.rejected["unknown finger"] += 1
        commands = self.commands(heard, now)
        for name in self.names:
            commands += self.watch(name, now)
        for name in heard:
            for _ in self.reports(name, now):  # what is told of the health has a memory
                pass
        return commands

    def contact(self, finger: str) -> ContactEstimate:
        """Return what is known of the contact of ``finger``; not valid while its input is not trusted.

        Raises:
            UsageError: there is no such finger.

        """
        return self.friction.state_friction(self._finger_called(finger).contact(self._now))

    def margin(self, finger: str) -> SlipMargin:
        """Return the slip margin of ``finger`` under its present load; errors as of :meth:`contact`."""
        return self._finger_called(finger).margin(self._now)

    def health(self, finger: str) -> ModelHealth:
        """Return whether the model explains what ``finger`` measures; errors as of :meth:`contact`."""
        return self.friction.name_suspect(self._finger_called(finger).health(self._now))

    def drive_lag(self, finger: str) -> float:
        """Return the measured lag [s] of the force of ``finger`` behind what it needs; NaN: not known.

        It is measured where ``grip.drive_lag`` or ``grip.measure_lag`` are set; errors as of :meth:`contact`.
        """
        return self.friction.drive_lag(self._finger_called(finger).name)

    @property
    def settings(self) -> ControlSettings:
        """How the grasp is controlled; new settings take effect at once, what is held and learned stays.

        With ``grip.slip_every`` they hold what follows from it.
        """
        return self._settings

    @settings.setter
    def settings(self, settings: ControlSettings) -> None:
        self._share_of = make_share(settings, self.names)
        self._settings = self._derived(settings)
        for finger in self.fingers.values():
            finger.apply(self._settings)
        self._lead()

    def reset(self) -> None:
        """Forget contacts and commands; nothing is commanded before the next state of a finger."""
        self._now = 0
        self.fingers = {name: self._new_finger(name) for name in self.names}
        self.friction = share_friction(self.fingers, self._settings, self._known_object())
        self._lead()

    # What a node calls one by one, because its states arrive one by one.

    def assimilate(self, state: FingertipState, now: int) -> bool:
        """Take one state of a finger of this hand; return whether it is believed."""
        finger = self.fingers[state.finger]
        wanted = self.friction.prepare(finger, self.wanted, self.wanted_known)
        shown = self.friction.screen(state)
        believed = finger.sense(shown, now, wanted, slides=self.friction.shows_sliding(shown))
        if believed:
            self.friction.learn(finger, state, wanted)
        return believed

    def commands(self, fingers: Iterable[str], now: int) -> list[ForceCommand]:
        """Return the commands of those of the ``fingers`` that have had a state."""
        chosen = [self.fingers[name] for name in fingers]
        return [finger.command(self._share(finger), now) for finger in chosen if finger.controller.started]

    def watch(self, finger: str, now: int) -> list[ForceCommand]:
        """Look whether ``finger`` is silent; return its command where the last one would expire."""
        watched = self.fingers[finger]
        watched.watch(now)
        return self.commands([finger], now) if watched.controller.due(now) else []

    def reports(self, finger: str, now: int) -> Iterator[Message]:
        """Yield what is due to be told of ``finger``, each by its period in the settings."""
        settings = self.settings
        return self.fingers[finger].reports(now, settings.report_period, settings.health_period)

    def ride_out(self, now: int) -> list[ForceCommand]:
        """Renew commands without the estimators: hold, then ramp to the fail-safe grip."""
        due = [finger for finger in self.fingers.values() if finger.controller.due(now)]
        for finger in due:
            finger.controller.update(Condition.STALE, UNTRUSTED_DEMAND, now)
        return self.commands([finger.name for finger in due], now)

    def restart(self) -> None:
        """Forget inputs and contacts but keep the commands, after :meth:`ride_out`."""
        for finger in self.fingers.values():
            finger.restart()

    def _warm_up(self) -> None:
        """Compile what will run, by running it on fingers that are thrown away; once for settings alike.

        The models have no part in it: each estimator compiles its own when it is made.
        """
        kind = repr((self._settings, len(self.names)))
        if kind in _WARM:
            return
        _WARM.add(kind)
        for name in self.names:
            for state in dummy_states(name):
                self.assimilate(state, state.stamp)
                self.commands([name], state.stamp)
                for _ in self.fingers[name].reports(state.stamp, 0.0, 0.0):
                    pass
        self.reset()

    def _new_finger(self, name: str) -> GraspFinger:
        settings = self.settings
        controller = FingerController(
            name, make_policy(settings), FailSafe(settings.fail_safe), settings.limits
        )
        groups = min(len(self.names), REPORT_GROUPS)
        phase = self.names.index(name) * groups // len(self.names) / groups
        watchdog = InputWatchdog(settings.watchdog)
        return GraspFinger(name, self._make_estimator(name), controller, watchdog, phase)

    def _derived(self, settings: ControlSettings) -> ControlSettings:
        grip = derive_grip(settings.grip, len(self.names))
        return settings if grip is settings.grip else replace(settings, grip=grip)

    def _lead(self) -> None:
        noise = getattr(self._settings, "noise", SensorNoise())
        self.friction.set_lead(self._settings.grip, noise.torque_z)
        for finger in self.fingers.values():
            self.friction.lead(finger)

    @property
    def wanted(self) -> Wanted:
        """Margin and confidence of each finger; all count, also those that are not heard."""
        grip = self.settings.grip
        rho = self.friction.correlation
        return grip.wanted_margin, each_confidence(grip.probability, len(self.names), rho)

    @property
    def wanted_known(self) -> Wanted:
        """The same of a finger whose friction is known."""
        return self.settings.grip.wanted_margin, self.settings.grip.known_probability

    def _share(self, finger: GraspFinger) -> float:
        needs = {other.name: self.need_of(other) for other in self.fingers.values()}
        started = {name: need for name, need in needs.items() if not math.isnan(need)}
        return self._share_of(started).get(finger.name, 0.0)

    def _finger_called(self, name: str) -> GraspFinger:
        if name not in self.fingers:
            raise UsageError(f"this hand has no finger {name!r}; {suggestion(name, self.names)}")
        return self.fingers[name]


def need_of(finger: GraspFinger) -> float:
    """Return what a finger needs [N], as its objects have it; NaN without a command."""
    return finger.controller.required_force if finger.controller.started else math.nan


def _from_models(
    fingers: tuple[str, ...],
    model: ContactModel | Mapping[str, ContactModel] | None,
    noise: SensorNoise | None,
    settings: EstimatorSettings | None,
) -> MakeEstimator:
    if model is None:
        raise UsageError(
            "a GripController needs the model of its fingertips, such as vegrip.paper_model(9e-3)"
        )
    models = dict(model) if isinstance(model, Mapping) else dict.fromkeys(fingers, model)
    missing = [name for name in fingers if name not in models]
    if missing:
        raise UsageError(
            f"there is no model of {', '.join(missing)}; there are models of {', '.join(models)}"
        )
    return lambda finger: ContactEstimator(models[finger], noise or SensorNoise(), settings)
