"""What all fingers of a grasp learn of friction together, between one finger's state and the next.

Before a finger takes a state, :meth:`GraspFriction.prepare` writes into its estimator what the grasp believes
of its friction, and says which margin and confidence to ask for. Afterwards :meth:`GraspFriction.learn` takes
what the finger has learned into the belief (:mod:`.friction_belief`, :mod:`.friction_onset`) and lets probing
go on (:mod:`.friction_probe`).

A finger whose slip is felt, of an object that is not unknown, counts on the bound of its friction at
``known_probability``: where that is wrong, it creeps a little, is held, and all know better. Others count on
the bound at the probability of the grasp. Probing raises what it counts on by ``b`` in ln mu, which is
the same as to ask for the margin ``1 - (1 - margin) e^b``.
"""

import math
from array import array
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple, Protocol, TypeGuard

import numpy as np

from vegrip.clock import NS
from vegrip.estimator.estimator import quantile
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.grip.drive_lag import begin_drives, measured_lag, tell_drives
from vegrip.grip.felt_slip import (
    FELT_BY_LOAD,
    FELT_BY_OTHER,
    FELT_DEAF,
    FELT_FLAG,
    FELT_OFF,
    FELT_SILENT,
    FELT_SPEED,
    FELT_WHY,
    FELT_WIDTH,
    begin_felt_slip,
    believed_flag,
    believed_speed,
    judge_felt_slip,
    may_teach,
    shows_sliding,
    twist_share,
)
from vegrip.grip.finger import GraspFinger, Wanted
from vegrip.grip.friction_belief import (
    BELIEF_MEAN,
    BELIEF_MOST,
    BELIEF_P,
    BELIEF_PRIOR_VAR,
    BELIEF_SINCE,
    BELIEF_VERSION,
    absorb_evidence,
    begin_belief,
    believed_variance,
    expect_finger,
    refuse_evidence,
    widen_own,
)
from vegrip.grip.friction_change import (
    CHANGE_LEVEL,
    CHANGE_SPREAD,
    begin_changes,
    follow_level,
    stated_friction,
)
from vegrip.grip.friction_onset import (
    ONSET_SILENT,
    begin_onsets,
    feel_onset,
    is_doubted,
)
from vegrip.grip.friction_probe import (
    LEAST_PROBE,
    PROBE_NEED,
    PROBE_SHIFT,
    PROBE_UNKNOWN,
    begin_probing,
    feel_slip,
    watch_load,
)
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.joint_confidence import FINGER_CORRELATION, shared_part
from vegrip.grip.known_objects import ObjectFriction
from vegrip.grip.late_slip import begin_late_slip, is_late, present_slip, recall_load
from vegrip.grip.load_lead import begin_lead
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.settings import ControlSettings
from vegrip.grip.slip_trust import (
    TRUST_PROOF,
    TRUST_SIZE,
    begin_trust,
    counted_shift,
    counts_as_known,
    ends_probe,
    follow_trust,
    is_constant,
    let_go,
)
from vegrip.messages import KNOWN, PROBED, ContactEstimate, Estimate, FingertipState, ModelHealth
from vegrip.types import NamedNumbers

LONGEST_STEP_S = 0.1
"""A longer pause between two states counts as so much."""
NEW_CONTACT_VARIANCE = 1e-4
"""Growth of the variance of ln mu between two states that only a new contact brings."""

CHANNELS_OF_SLIP = {FELT_FLAG: "slip", FELT_SPEED: "slip_speed"}

CONTRADICTIONS = {
    FELT_BY_LOAD: "says slip while its load shows none",
    FELT_BY_OTHER: "says slip while its slip speed shows none",
    FELT_SILENT: "is silent or late while its slip speed shows slip",
    FELT_DEAF: "is silent in a slide that its load shows",
}
"""What is wrong with a channel, by :data:`~vegrip.grip.felt_slip.FELT_WHY`."""


class FingerFriction(NamedTuple):
    """What an estimator believes of ln mu: now, and before the present loading."""

    mean: float
    variance: float
    mean_before: float
    variance_before: float


class Utilisation(NamedTuple):
    """Friction coefficient at which the present load would slip, its relative std, and the load [N]."""

    value: float
    relative_std: float
    load: float


class FrictionEstimator(Protocol):
    """An estimator that can be told of friction, as :class:`vegrip.estimator.ContactEstimator` can."""

    @property
    def in_contact(self) -> bool:
        """Whether the fingertip touches."""

    @property
    def friction(self) -> tuple[float, float, float, float]:
        """The fields of :class:`FingerFriction`."""

    def believe_friction(self, belief: tuple[float, float, float, float]) -> None:
        """Go on from this belief."""

    def utilisation(self) -> tuple[float, float, float]:
        """Return the fields of :class:`Utilisation`, NaN where they are not known."""


def can_share(estimator: object) -> TypeGuard[FrictionEstimator]:
    """Return whether an estimator can be told of friction; asks its class, so nothing is computed."""
    return all(hasattr(type(estimator), name) for name in ("friction", "believe_friction", "utilisation"))


class GraspFriction:
    """Friction of the contacts of one object.

    Args:
        fingers: the estimator of each, by name; one that cannot be told friction makes all learn alone.
        settings: how friction is learned.
        tangential_noise: std of the measured tangential force [N].
        drift: random walk of ln mu [1/sqrt(s)].
        known: what former grasps have learned of the object.
        normal_noise: std of the measured normal force [N].

    """

    def __init__(
        self,
        fingers: Mapping[str, object],
        settings: FrictionSettings,
        tangential_noise: float,
        drift: float,
        known: ObjectFriction | None = None,
        normal_noise: float = 0.01,
    ) -> None:
        able = {name: e for name, e in fingers.items() if can_share(e)}
        self.active = settings.shared and len(able) == len(fingers) <= BELIEF_MOST
        self._settings, self._noise = settings, tangential_noise
        self._places = {name: i for i, name in enumerate(fingers)}
        self._memory = array("d", bytes(8 * max(TRUST_SIZE, len(fingers))))
        self.shared = np.frombuffer(self._memory)
        """All that the fingers of the grasp share, as the compiled step has it; the same numbers as here."""
        self._seen = [0.0] * len(fingers)  # version of the belief that each finger has
        self._site = [(0.0, 0.0)] * len(fingers)  # its own evidence of the present loading
        self._before = [(0.0, 0.0)] * len(fingers)  # mean and variance it had before its last state
        self._stamp = [0] * len(fingers)
        self._is_leading = False
        self.correlation = FINGER_CORRELATION
        """Of what is not known of the fingers' friction before anything is felt [-]."""
        begin_drives(self._memory, normal_noise)
        if self.active:
            self._begin(able, drift, known)

    def _begin(
        self, able: Mapping[str, FrictionEstimator], drift: float, known: ObjectFriction | None
    ) -> None:
        s, g = self._settings, self._memory
        begin_belief(g, len(able), drift, s.shock)
        for i, estimator in enumerate(able.values()):
            mean, variance, _, _ = estimator.friction
            widest = max(variance, 0.0)
            if known is not None and known.prior[1] ** 2 < widest:
                mean, variance = known.prior[0], known.prior[1] ** 2
                estimator.believe_friction(FingerFriction(mean, variance, mean, variance))
            rho = shared_part(math.sqrt(max(variance, 0.0)), s.own_spread)
            self.correlation = rho if i == 0 else min(rho, self.correlation)
            expect_finger(g, i, mean, math.sqrt(max(variance, 0.0)), s.own_spread)
            g[BELIEF_PRIOR_VAR] = max(g[BELIEF_PRIOR_VAR], widest)  # forgetting leads back to what is usual
            self._before[i] = mean, variance
        probing = s.probing and not s.why_too_coarse
        begin_probing(
            g, s.climb if probing else 0.0, s.rate if probing else 0.0, s.unknown, s.known,
            s.quiet_time, s.quiet_change, s.pause, s.reach,
        )  # fmt: skip
        begin_onsets(g, s.onset_noise if s.onsets else math.inf, s.shock)
        begin_felt_slip(g, s.sliding_speed, s.slip_delay)
        begin_late_slip(g)
        begin_changes(g)
        begin_trust(g, g)

    def prepare(self, finger: GraspFinger, unknown: Wanted, known: Wanted) -> Wanted:
        """Tell the estimator of ``finger`` what the grasp believes; return margin and confidence to ask for.

        Args:
            finger: whose state comes next.
            unknown: margin and confidence wanted where slip would not be felt.
            known: the same where it is.

        """
        estimator = finger.estimator
        if not (self.active and can_share(estimator)):
            return unknown
        i = self._places[finger.name]
        own = FingerFriction(*estimator.friction)
        if own.mean == own.mean_before and own.variance == own.variance_before:
            self._site[i] = 0.0, 0.0
        if self._memory[BELIEF_VERSION] != self._seen[i]:
            self._seen[i] = self._memory[BELIEF_VERSION]
            own = self._told(i)
            estimator.believe_friction(own)
        self._before[i] = own.mean, own.variance
        margin, confidence = known if counts_as_known(self._memory, self._memory, i) else unknown
        shift = counted_shift(self._memory, self._memory, i, quantile(confidence))
        return 1.0 - (1.0 - margin) * math.exp(shift), confidence

    def screen(self, state: FingertipState) -> FingertipState:
        """Return ``state`` with what is believed of slip.

        What the load has shown to be wrong counts as not sensed, and a slide that is over as none.
        """
        if not self.active:
            return state
        g, i = self._memory, self._places[state.finger]
        slip = present_slip(g, i, believed_flag(g, i, state.slip))
        speed = present_slip(g, i, believed_speed(g, i, state.slip_speed))
        if slip == state.slip and speed == state.slip_speed:
            return state
        return replace(state, slip=slip, slip_speed=speed)

    def shows_sliding(self, state: FingertipState) -> bool:
        """Return whether the slip speed of a screened ``state`` is one of a finger that slides."""
        return self.active and shows_sliding(self._memory, state.slip_speed)

    def learn(self, finger: GraspFinger, state: FingertipState, wanted: Wanted) -> None:
        """Take in what ``finger`` learned of its last ``state``, which was judged as ``wanted``."""
        estimator = finger.estimator
        if not (self.active and can_share(estimator)):
            return
        i, g = self._places[finger.name], self._memory
        asked, lag = wanted[0], quantile(wanted[1])
        dt = min(max((state.stamp - self._stamp[i]) / NS, 0.0), LONGEST_STEP_S) if self._stamp[i] else 0.0
        self._stamp[i] = state.stamp
        g[BELIEF_SINCE] += dt / len(self._places)
        flag, speed = believed_flag(g, i, state.slip), believed_speed(g, i, state.slip_speed)
        slipping, touching = flag >= 0.5, estimator.in_contact
        is_evidence = may_teach(g, i)
        refused = slipping and (is_late(g) or not is_evidence)
        self._take_evidence(i, FingerFriction(*estimator.friction), refused=refused)
        u, relative, load = estimator.utilisation()
        vague = relative if is_evidence else math.inf
        feel_onset(g, g, i, dt, recall_load(g, i, dt, u), vague, flag, speed)
        g[PROBE_NEED + i] = finger.controller.required_force
        watch_load(g, i, dt, load, self._noise, touching)
        x, y = state.tangential_force_x, state.tangential_force_y
        pull = math.sqrt(x * x + y * y)
        follow_trust(
            g, g, i, dt, flag, state.slip_speed, u, relative, state.normal_force, pull, self._noise, touching
        )
        slides = ends_probe(g, i, dt, slipping, shows_sliding(g, speed))
        feel_slip(g, dt, len(self._places), slides)
        let_go(g, g, i, dt, lag, asked, u, self._noise, touching, slides)
        twist = twist_share(pull, load)
        judge_felt_slip(g, i, dt, state.slip, state.slip_speed, u, twist)
        follow_level(g, g, i, dt)

    def lead(self, finger: GraspFinger) -> None:
        """Let ``finger`` answer the load that is to come by the lag of its drive, see :meth:`set_lead`."""
        i = self._places[finger.name]
        finger.lead_in = (self._memory, i) if self._is_leading and i < BELIEF_MOST else None

    def set_lead(self, grip: GripSettings, torque_noise: float) -> None:
        """Set what is told of the drives, and the noise of a torque [N m]; what was measured stays."""
        self._is_leading = grip.drive_lag > 0.0 or grip.measure_lag
        tell_drives(self._memory, grip.drive_lag, grip.measure_lag, grip.burst_rate)
        begin_lead(self._memory, self._noise, torque_noise)

    def drive_lag(self, finger: str) -> float:
        """Return the measured lag of the drive of ``finger`` [s]; NaN while it is not known."""
        i = self._places[finger]
        return measured_lag(self._memory, i) if i < BELIEF_MOST else math.nan

    def write_to(self, memory: NamedNumbers, finger: str, wanted: Wanted) -> None:
        """Lend what is of one finger; ``wanted`` of it once its friction is known."""
        i = self._places[finger]
        precision, weighted = self._site[i]
        memory["SETUP_SHARES"], memory["SETUP_LEADS"] = self.active, self._is_leading
        memory["SHARED_KNOWN_QUANTILE"] = quantile(wanted[1])
        memory["SHARED_WIDEST"], memory["SHARED_LOAD_NOISE"] = self._settings.widest_variance, self._noise
        memory["SHARED_SEEN"], memory["TURN_LEARNED"] = self._seen[i], self._stamp[i]
        memory["SHARED_SITE"], memory["SHARED_SITE_WEIGHTED"] = precision, weighted
        if self.active:
            level, spread, unknown = self._change_of(i)
            memory["SHARED_LEVEL"], memory["SHARED_SPREAD"] = level, spread
            memory["SHARED_UNKNOWN"] = unknown

    def read_from(self, memory: NamedNumbers, finger: str) -> None:
        """Take back what is of one finger."""
        i = self._places[finger]
        self._seen[i], self._stamp[i] = memory["SHARED_SEEN"], int(memory["TURN_LEARNED"])
        self._site[i] = memory["SHARED_SITE"], memory["SHARED_SITE_WEIGHTED"]

    @property
    def why_not_probing(self) -> str:
        """Why force is not let go of to learn friction; empty while it is."""
        if not self.active or not self._settings.probing:
            return "probing is switched off"
        if self._settings.why_too_coarse:
            return self._settings.why_too_coarse
        return next(filter(None, map(self._why_not_heard, self._places)), "")

    def _why_not_heard(self, finger: str) -> str:
        g, i = self._memory, self._places[finger]
        if found := self.suspicion(finger):
            return found
        if g[ONSET_SILENT + i] > 0.5:
            return f"{finger} does not feel slip"
        if is_doubted(g, i):
            return f"the slip channel of {finger} contradicts its load"
        if g[TRUST_PROOF + i] == 0.0 and is_constant(g, i):
            return f"{finger} has not felt slip yet, and its slip speed shows no noise: it may be dead"
        return ""

    def doubted_channel(self, finger: str) -> str:
        """Return which channel of ``finger`` is not believed, because it is wrong of slip; empty = none."""
        if not self.active:
            return ""
        i = self._places[finger]
        found = (
            name
            for at, name in CHANNELS_OF_SLIP.items()
            if self._memory[at + FELT_WIDTH * i + FELT_OFF] > 0.0
        )
        return next(found, "")

    def suspicion(self, finger: str) -> str:
        """Return what is wrong with what ``finger`` feels of slip, in a sentence; empty while all is well."""
        channel = self.doubted_channel(finger)
        if not channel:
            return ""
        at = FELT_FLAG if channel == "slip" else FELT_SPEED
        wrong = CONTRADICTIONS[self._memory[at + FELT_WIDTH * self._places[finger] + FELT_WHY]]
        return f"the channel '{channel}' of {finger} {wrong}, and is not used"

    def friction_counted_on(self, finger: str) -> str:
        """Return how ``finger`` counts on friction: PROBED, KNOWN, or "" for what is usual."""
        if not self.active:
            return ""
        i = self._places[finger]
        if self._memory[PROBE_SHIFT + i] > LEAST_PROBE:
            return PROBED
        return KNOWN if counts_as_known(self._memory, self._memory, i) else ""

    def name_suspect(self, health: ModelHealth) -> ModelHealth:
        """Return ``health`` with the channel that is not believed, instead of what the model fails at.

        What the grip counts on of friction is in it, too.
        """
        channel, friction = self.doubted_channel(health.finger), self.friction_counted_on(health.finger)
        if channel:
            return replace(health, channel=channel, regime="", suspect="", friction=friction)
        return health if friction == health.friction else replace(health, friction=friction)

    def state_friction(self, contact: ContactEstimate) -> ContactEstimate:
        """Return ``contact`` with the friction that is stated (:mod:`vegrip.grip.friction_change`)."""
        mu = contact.friction_coefficient
        if not (self.active and contact.finger in self._places and 0.0 < mu.value < math.inf):
            return contact
        i = self._places[contact.finger]
        level, spread, unknown = self._change_of(i)
        mean, std = stated_friction(math.log(mu.value), mu.std / mu.value, level, spread, unknown)
        value = math.exp(mean)
        return replace(contact, friction_coefficient=Estimate(value, value * std, mu.valid, mu.age))

    @property
    def learned_object(self) -> ObjectFriction | None:
        """What this grasp has learned of the object; None while it is unknown."""
        n = len(self._places)
        if not self.active or self._memory[BELIEF_VERSION] == 0.0:
            return None
        rows = [self._memory[BELIEF_P + i * BELIEF_MOST : BELIEF_P + i * BELIEF_MOST + n] for i in range(n)]
        std = math.sqrt(max(sum(map(sum, rows)), 0.0)) / n
        if not 0.0 < std <= self._settings.unknown:
            return None
        return ObjectFriction(sum(self._memory[BELIEF_MEAN : BELIEF_MEAN + n]) / n, std)

    def belief(self, finger: str) -> tuple[float, float]:
        """Return mean and standard deviation of ln mu of ``finger`` as the grasp believes it."""
        i = self._places[finger]
        return self._memory[BELIEF_MEAN + i], math.sqrt(believed_variance(self._memory, i))

    def _change_of(self, i: int) -> tuple[float, float, float]:
        g = self._memory
        return g[CHANGE_LEVEL + i], g[CHANGE_SPREAD + i], g[PROBE_UNKNOWN]

    def _told(self, i: int) -> FingerFriction:
        """Return the belief of finger ``i``, and the same without its evidence of the present loading."""
        mean, variance = self._memory[BELIEF_MEAN + i], believed_variance(self._memory, i)
        precision, weighted = self._site[i]
        left = 1.0 / variance - precision if variance > 0.0 else 0.0
        if precision == 0.0 or not left > 1.0 / self._settings.widest_variance:
            return FingerFriction(mean, variance, mean, variance)
        return FingerFriction(mean, variance, (mean / variance - weighted) / left, 1.0 / left)

    def _take_evidence(self, i: int, own: FingerFriction, *, refused: bool) -> None:
        mean, variance = self._before[i]
        if own.mean == mean:
            if own.variance > variance + NEW_CONTACT_VARIANCE:
                widen_own(self._memory, i, own.variance)
            return
        if refused:
            refuse_evidence(self._memory)
        elif variance > 0.0 and own.variance > 0.0:
            precision, weighted = self._site[i]
            precision += 1.0 / own.variance - 1.0 / variance
            self._site[i] = precision, weighted + own.mean / own.variance - mean / variance
            absorb_evidence(self._memory, i, mean, variance, own.mean, own.variance)


def share_friction(
    fingers: Mapping[str, GraspFinger], settings: ControlSettings, known: ObjectFriction | None = None
) -> GraspFriction:
    """Return what ``fingers`` learn of friction together, from what their estimators believe now.

    Args:
        fingers: by name.
        settings: of the grasp.
        known: what former grasps have learned of the object.

    """
    noise = getattr(settings, "noise", SensorNoise())
    estimator = getattr(settings, "estimator", EstimatorSettings())
    return GraspFriction(
        {name: finger.estimator for name, finger in fingers.items()},
        settings.friction,
        noise.tangential_force,
        estimator.friction_drift,
        known,
        noise.normal_force,
    )
