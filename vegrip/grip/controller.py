"""Grip control of a hand without a bus: fingertip states in, force commands out. Public.

::

    hand = vegrip.GripController(("thumb", "index"), model=vegrip.paper_model(tip_radius=9e-3))
    commands = hand.step(states, now)  # in your own loop
    hand.margin("thumb").lower_bound

It has all that stands between a state and a command: estimator, watchdog of the input, grip policy, balance
of the grasp, fail-safe, limits, renewal of commands before they expire. The node on a bus
(:class:`~vegrip.grip.node.GraspForce`) is this controller with a lifecycle around it.
"""

import logging
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from vegrip import messages
from vegrip.config import check
from vegrip.errors import KindError, UsageError, suggestion
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import GraspFinger
from vegrip.grip.finger_step import Place
from vegrip.grip.force_parts import ForceParts, force_parts
from vegrip.grip.grasp_friction import GraspFriction
from vegrip.grip.known_objects import ObjectFriction
from vegrip.grip.limit_watch import LimitWatch, against_thumb
from vegrip.grip.safety import USUAL_LIMITS, limit_not_stated
from vegrip.grip.settings import ControlSettings, Share, check_settings, fixed_changes, make_share
from vegrip.grip.step_time import StepTime
from vegrip.grip.wires import LEFT_ALONE
from vegrip.model import ContactModel
from vegrip.transport.codec.frame_codec import Line

REPORT_GROUPS = 5
"""Fingers that report at different times; of more, some report together, in one message where that is so."""

MakeEstimator = Callable[[str], Estimator]
"""Gives a new estimator for the finger of this name."""


class GripController:
    """Grip control of any number of fingers that hold one object.

    Nothing here raises once it is built, whatever the states contain. Time comes in as ``now`` [ns] of a
    monotonic clock, the one that stamps the states; a step at an impossible time is left out.

    Args:
        fingers: their names.
        model: of every fingertip, or of each by its name.
        noise: of the sensors; the default is that of :class:`~vegrip.estimator.SensorNoise`.
        settings: how the grasp is controlled; state the largest force that fingers and object bear,
            ``ControlSettings(limits=LimitSettings(max_force=8.0))``, or it is 15 N, which is logged.
        estimator: how the estimators behave.
        make_estimator: gives the estimator of a finger, instead of ``model``, ``noise`` and ``estimator``.
        known_object: gives what former grasps have learned of the object, asked at every beginning: what
            ``friction.learned_object`` said at the end of one. ``settings.friction.object`` is for a node,
            which keeps it in a file.

    Raises:
        UsageError: there is neither a model nor ``make_estimator``, a finger without a model, or two of one
            name.
        ConfigError: the settings, or what is known of the object, cannot be used.
        KindError: an argument is of the wrong kind.
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
        self.names = _names_in(fingers)
        self.rejected: Counter[str] = Counter()
        """What was not taken, counted by name: states, and steps whose time is wrong."""
        self._limit_is_unstated = settings is None or settings.limits is USUAL_LIMITS
        self._settings = settings or ControlSettings()
        self._noise, self._estimator = noise or SensorNoise(), estimator or EstimatorSettings()
        if not callable(known_object):
            raise KindError(f"known_object is {known_object!r}; give a function, lambda: {known_object!r}")
        check(self._noise, "noise")
        check(self._estimator, "estimator")
        self._models = {} if make_estimator is not None else _models_of(self.names, model)
        self._make_estimator = make_estimator or self._from_model
        self._known_object = known_object
        self._share_of: Share | None = None
        self.limit_watch = LimitWatch(self._shares)
        """Whether the largest force suffices, looked at with every report."""
        self._lines: Mapping[str, Line] = {}
        self._mode = ""
        self._time = StepTime()
        self.fingers: dict[str, GraspFinger] = {}
        self.reset(self._settings)

    def step(self, states: Iterable[messages.FingertipState], now: int) -> list[messages.ForceCommand]:
        """Take the states that arrived at ``now`` [ns]; return the commands that are to be sent.

        One command for each finger of which a state came, and one for each whose last command would else
        expire: call it also when nothing came. A finger is commanded from its first state on.
        """
        if (moved := self._time.take(now)) is None:
            self.rejected["wrong time"] += 1
            return []
        if moved:
            for finger in self.fingers.values():
                finger.move_times(moved)
        now = self._time.now
        if self._limit_is_unstated:
            self._limit_is_unstated = False
            logging.getLogger("vegrip.grip").warning("%s", limit_not_stated(self._settings.limits))
        received: dict[str, None] = {}
        for state in states:
            if not self._knows(state):
                self.rejected["unknown finger"] += 1
            elif self.assimilate(state, now) is not None:
                received[state.finger] = None
        commands = self.commands(received, now)
        for name in self.names:
            commands += self.watch(name, now)
        for name in received:
            for _ in self.reports(name, now):  # the report of the health has a memory
                pass
        return commands

    def contact(self, finger: str) -> messages.ContactEstimate:
        """Return what is known of the contact of ``finger``; not valid while its input is not trusted.

        Raises:
            UsageError: there is no such finger.

        """
        return self.friction.state_friction(self._finger_called(finger).reports.contact(self._time.now))

    def margin(self, finger: str) -> messages.SlipMargin:
        """Return the slip margin of ``finger`` under its present load; errors as of :meth:`contact`."""
        return self._finger_called(finger).reports.margin(self._time.now)

    def health(self, finger: str) -> messages.ModelHealth:
        """Return whether the model explains what ``finger`` measures; errors as of :meth:`contact`.

        And whether ``limits.max_force`` suffices for it, or soon may not (``limit``).
        """
        health = self.friction.report_unsound(self._finger_called(finger).reports.health(self._time.now))
        return replace(health, limit=self.limit_watch.state(finger))

    def explain(self, finger: str) -> ForceParts:
        """Return what the last command of ``finger`` is made of, to print; errors as of :meth:`contact`."""
        one = self._finger_called(finger)
        needs = {name: other.need for name, other in self.fingers.items() if other.started}
        return force_parts(one, self._shares(needs).get(finger, math.nan))

    def drive_lag(self, finger: str) -> float:
        """Return the measured lag [s] of the force of ``finger`` behind what it needs; NaN: not known.

        It is measured where it is stated or friction is learned; errors as of :meth:`contact`.
        """
        return self.friction.drive_lag(self._finger_called(finger).name)

    @property
    def settings(self) -> ControlSettings:
        """How the grasp is controlled; new settings take effect at once, what is held and learned stays.

        Those that are fixed (policy, thumb, contacts, friction) cannot be changed so, but by :meth:`reset`.

        Raises:
            ConfigError: they cannot be used.
            UsageError: one that is fixed is another; it is named, and all stay as they were.

        """
        return self._settings

    @settings.setter
    def settings(self, settings: ControlSettings) -> None:
        check_settings(settings, self.names, self._settings)
        if changed := ", ".join(fixed_changes(self._settings, settings)):
            raise UsageError(
                f"{changed} cannot be changed while the hand grips; give the settings to reset()"
            )
        self._settings = settings
        self._apply()

    def reset(self, settings: ControlSettings | None = None) -> None:
        """Forget contacts and commands; nothing is commanded before the next state of a finger.

        With ``settings``, all of which take effect; errors as at the beginning.
        """
        if settings is not None:
            check_settings(settings, self.names)
            self._share_of, self._settings = make_share(settings, self.names), settings
        self._time = StepTime()
        estimators = {name: self._make_estimator(name) for name in self.names}
        self.friction = GraspFriction(estimators, self._settings, self._known_object())
        self.fingers = {name: self._new_finger(name, estimator) for name, estimator in estimators.items()}
        self._apply()

    def follow_lines(self, lines: Mapping[str, Line], mode: str = "") -> None:
        """Take the frames of ``lines`` from now on, finger by finger; ``mode`` says what runs the step."""
        self._lines, self._mode = lines, mode
        for name, finger in self.fingers.items():
            finger.numbers.follow_line(lines.get(name), mode)

    # What a node calls one by one, because its states arrive one by one.

    def answer(self, state: messages.FingertipState, now: int) -> int:
        """Answer one state of a finger of this hand; return what was done, in bits."""
        finger = self.fingers[state.finger]
        if not finger.is_whole:
            is_left_alone = self.assimilate(state, now) is None
            return LEFT_ALONE if is_left_alone else finger.settle(now, self._share(finger))
        done = finger.answer(state, now)
        if done == LEFT_ALONE:
            self.rejected["broken state"] += 1
        return done

    def assimilate(self, state: messages.FingertipState, now: int) -> bool | None:
        """Take one state of a finger of this hand; return whether it is accepted, None: it is broken."""
        accepted = self.fingers[state.finger].sense(state, now)
        if accepted is None:
            self.rejected["broken state"] += 1
        return accepted

    def commands(self, fingers: Iterable[str], now: int) -> list[messages.ForceCommand]:
        """Return the commands of those of the ``fingers`` that have had a state."""
        commands = []
        for finger in [self.fingers[name] for name in fingers]:
            if finger.started:
                finger.settle(now, self._share(finger))
                commands.append(finger.command())
        return commands

    def watch(self, finger: str, now: int) -> list[messages.ForceCommand]:
        return self.commands([finger], now) if self.fingers[finger].watch(now) else []

    def reports(self, finger: str, now: int) -> Iterator[messages.Message]:
        self.limit_watch.look(self.fingers, self._settings.limits.max_force, now)
        for report in self.fingers[finger].reports.due(now):
            if isinstance(report, messages.ModelHealth):
                yield replace(report, limit=self.limit_watch.state(finger))
            else:
                yield report

    def hold_last(self, now: int) -> list[messages.ForceCommand]:
        """Renew commands without the estimators: hold, then ramp to the fail-safe grip."""
        return self.commands([name for name, finger in self.fingers.items() if finger.hold_last(now)], now)

    def restart(self) -> None:
        """Forget inputs and contacts but keep the commands, after :meth:`hold_last`."""
        for finger in self.fingers.values():
            finger.restart()

    def place_of(self, name: str) -> Place:
        names, thumb = self.names, self._settings.thumb
        return Place(names.index(name), len(names), names.index(thumb) if thumb in names else -1)

    def _from_model(self, finger: str) -> ContactEstimator:
        settings = replace(self._estimator, friction=self._settings.friction.prior_of())
        return ContactEstimator(self._models[finger], self._noise, settings)

    def _new_finger(self, name: str, estimator: Estimator) -> GraspFinger:
        groups = min(len(self.names), REPORT_GROUPS)
        phase = self.names.index(name) * groups // len(self.names) / groups
        return GraspFinger(
            name, estimator, self._settings, self.place_of(name), self.friction.memory,
            phase=phase, line=self._lines.get(name), mode=self._mode,
        )  # fmt: skip

    def _apply(self) -> None:
        self.friction.set_lead(self._settings.grip)
        self.friction.set_risk(self._settings.grip)
        for name, finger in self.fingers.items():
            finger.apply(self._settings)
            self.friction.write_to(finger.memory, name)

    def _knows(self, state: messages.FingertipState) -> bool:
        try:
            return state.finger in self.fingers
        except (AttributeError, TypeError):  # no state at all, or one whose finger is no name
            return False

    def _share(self, finger: GraspFinger) -> float:
        """Return what ``finger`` is to press with [N] by the places of the contacts; NaN without them."""
        if self._share_of is None:
            return math.nan
        needs = {other.name: other.need for other in self.fingers.values()}
        started = {name: need for name, need in needs.items() if not math.isnan(need)}
        return self._share_of(started).get(finger.name, 0.0)

    def _shares(self, needs: Mapping[str, float]) -> Mapping[str, float]:
        """Return what each finger presses with [N] where these are the ``needs``."""
        share = self._share_of
        return share(needs) if share is not None else against_thumb(needs, self._settings.thumb)

    def _finger_called(self, name: str) -> GraspFinger:
        if name not in self.fingers:
            raise UsageError(f"this hand has no finger {name!r}; {suggestion(name, self.names)}")
        return self.fingers[name]


def _names_in(fingers: Sequence[str]) -> tuple[str, ...]:
    names = () if isinstance(fingers, str) else tuple(fingers)
    if isinstance(fingers, str) or not all(isinstance(name, str) for name in names):
        raise KindError(f"fingers is {fingers!r}; give the names of the fingers, as in ('thumb', 'index')")
    if twice := sorted(name for name, times in Counter(names).items() if times > 1):
        raise UsageError(f"more than one finger is called {', '.join(twice)}; give each a name of its own")
    return names


def _models_of(
    fingers: tuple[str, ...], model: ContactModel | Mapping[str, ContactModel] | None
) -> Mapping[str, ContactModel]:
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
    return models
