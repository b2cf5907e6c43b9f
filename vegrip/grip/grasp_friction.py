"""What all fingers of a grasp learn of friction together: how it begins, and what is told of it.

Before a finger takes a state, its step (:mod:`vegrip.grip.kernels.friction_shared`) writes into its estimate
what the grasp believes of its friction, and chooses margin and confidence. Afterwards it takes what the
finger has learned into the belief (:mod:`.friction_belief`, :mod:`.friction_onset`) and lets probing go on
(:mod:`.friction_probe`).

A finger whose slip is felt, of an object that is not unknown, counts on the bound of its friction at
``known_probability``: where that is wrong, it creeps a little, is held, and all know better. Others count on
the bound at the probability of the grasp. Probing raises what it counts on by ``b`` in ln mu, which is
the same as to ask for the margin ``1 - (1 - margin) e^b``.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

from vegrip.estimator.estimator import ContactEstimator, quantile
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.grip.finger import Wanted
from vegrip.grip.friction_settings import WIDEST_VARIANCE, FrictionSettings
from vegrip.grip.grasp_memory import BELIEF_MOST, BELIEF_ROW, GraspMemory
from vegrip.grip.joint_confidence import FINGER_CORRELATION, shared_part
from vegrip.grip.known_objects import ObjectFriction
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.settings import ControlSettings
from vegrip.grip.slip_trust import *
from vegrip.messages import KNOWN, PROBED, ContactEstimate, Estimate, ModelHealth
from vegrip.types import NamedNumbers

CHANNELS_OF_SLIP = ("slip", "slip_speed")

CONTRADICTIONS = {
    FELT_BY_LOAD: "says slip while its load shows none",
    FELT_BY_OTHER: "says slip while its slip speed shows none",
    FELT_SILENT: "is silent or late while its slip speed shows slip",
    FELT_DEAF: "is silent in a slide that its load shows",
}
"""What is wrong with a channel, by ``why`` of :class:`~vegrip.grip.grasp_memory.Felt`."""


class GraspFriction:
    """Friction of the contacts of one object.

    Args:
        fingers: the estimator of each, by name; one of another make makes all learn alone.
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
        able = {name: e for name, e in fingers.items() if isinstance(e, ContactEstimator)}
        self.active = settings.shared and len(able) == len(fingers) <= BELIEF_MOST
        self._settings, self._noise = settings, tangential_noise
        self._places = {name: i for i, name in enumerate(fingers)}
        self.memory = GraspMemory(len(fingers))
        """All that the fingers of the grasp share; their steps write here."""
        self._is_leading = False
        self.correlation = FINGER_CORRELATION
        """Of what is not known of the fingers' friction before anything is felt [-]."""
        begin_drives(self.memory, normal_noise)
        if self.active:
            self._begin(able, drift, known)

    def _begin(
        self, able: Mapping[str, ContactEstimator], drift: float, known: ObjectFriction | None
    ) -> None:
        s, g = self._settings, self.memory
        for i, estimator in enumerate(able.values()):
            mean, variance, exponent, exponent_var = estimator.friction_law
            if i == 0:
                begin_belief(g, len(able), drift, s.shock)
                expect_exponent(g, exponent, exponent_var)
            widest = max(variance, 0.0)
            if known is not None and known.prior[1] ** 2 < widest:
                mean, variance = known.prior[0], known.prior[1] ** 2
                g.belief.version += 1.0
            rho = shared_part(math.sqrt(max(variance, 0.0)), s.own_spread)
            self.correlation = rho if i == 0 else min(rho, self.correlation)
            expect_finger(g, i, mean, math.sqrt(max(variance, 0.0)), s.own_spread)
            g.belief.prior_var = max(g.belief.prior_var, widest)  # forgetting leads back to what is usual
        probing = s.probing and not s.why_too_coarse
        begin_probing(
            g, s.climb if probing else 0.0, s.rate if probing else 0.0, s.unknown, s.known,
            s.quiet_time, s.quiet_change, s.pause, s.reach,
        )  # fmt: skip
        begin_onsets(g, s.onset_noise if s.onsets else math.inf, s.shock)
        begin_felt_slip(g, s.sliding_speed, s.slip_delay)
        begin_late_slip(g)
        begin_changes(g)
        begin_trust(g)

    def set_lead(self, grip: GripSettings, torque_noise: float) -> None:
        """Set what is told of the drives, and the noise of a torque [N m]; what was measured stays."""
        self._is_leading = grip.drive_lag > 0.0 or grip.measure_lag
        tell_drives(self.memory, grip.drive_lag, grip.measure_lag, grip.burst_rate)
        begin_lead(self.memory, self._noise, torque_noise)

    def drive_lag(self, finger: str) -> float:
        """Return the measured lag of the drive of ``finger`` [s]; NaN while it is not known."""
        i = self._places[finger]
        return measured_lag(self.memory, i) if i < BELIEF_MOST else math.nan

    def write_to(self, memory: NamedNumbers, finger: str, wanted: Wanted) -> None:
        """Let the step of a finger know what is set; ``wanted`` of it once its friction is known."""
        i = self._places[finger]
        memory["SETUP_SHARES"] = self.active
        memory["SETUP_LEADS"] = self._is_leading and i < BELIEF_MOST
        memory["SHARED_KNOWN_QUANTILE"] = quantile(wanted[1])
        memory["SHARED_WIDEST"], memory["SHARED_LOAD_NOISE"] = WIDEST_VARIANCE, self._noise
        if self.active:
            level, spread, unknown = self._change_of(i)
            memory["SHARED_LEVEL"], memory["SHARED_SPREAD"] = level, spread
            memory["SHARED_UNKNOWN"] = unknown

    @property
    def why_not_probing(self) -> str:
        """Why force is not let go of to learn friction; empty while it is."""
        if not self.active or not self._settings.probing:
            return "probing is switched off"
        if self._settings.why_too_coarse:
            return self._settings.why_too_coarse
        return next(filter(None, map(self._why_not_heard, self._places)), "")

    def _why_not_heard(self, finger: str) -> str:
        g, i = self.memory, self._places[finger]
        if found := self.suspicion(finger):
            return found
        if g.onset.silent[i] > 0.0:
            return f"{finger} does not feel slip"
        if is_doubted(g, i):
            return f"the slip channel of {finger} contradicts its load"
        if g.trust.proof[i] == 0.0 and is_constant(g, i):
            return f"{finger} has not felt slip yet, and its slip speed shows no noise: it may be dead"
        return ""

    def doubted_channel(self, finger: str) -> str:
        """Return which channel of ``finger`` is not believed, because it is wrong of slip; empty = none."""
        if not self.active:
            return ""
        channel = self._doubted(finger)
        return CHANNELS_OF_SLIP[channel >= BELIEF_MOST] if channel >= 0 else ""

    def _doubted(self, finger: str) -> int:
        """Return the place of the channel of ``finger`` that is not believed; -1: there is none."""
        flag = self._places[finger]
        return next((at for at in (flag, BELIEF_MOST + flag) if self.memory.felt.off[at] > 0.0), -1)

    def suspicion(self, finger: str) -> str:
        """Return what is wrong with what ``finger`` feels of slip, in a sentence; empty while all is well."""
        channel = self.doubted_channel(finger)
        if not channel:
            return ""
        wrong = CONTRADICTIONS[self.memory.felt.why[self._doubted(finger)]]
        return f"the channel '{channel}' of {finger} {wrong}, and is not used"

    def friction_counted_on(self, finger: str) -> str:
        """Return how ``finger`` counts on friction: PROBED, KNOWN, or "" for what is usual."""
        if not self.active:
            return ""
        i = self._places[finger]
        if self.memory.probe.shift[i] > LEAST_PROBE:
            return PROBED
        return KNOWN if counts_as_known(self.memory, i) else ""

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
        mean, std = self.stated_friction(contact.finger, math.log(mu.value), mu.std / mu.value)
        value = math.exp(mean)
        return replace(contact, friction_coefficient=Estimate(value, value * std, mu.valid, mu.age))

    def stated_friction(self, finger: str, mean: float, std: float) -> tuple[float, float]:
        """Return mean and standard deviation of ln mu that are stated where these are believed."""
        if not self.active:
            return mean, std
        return stated_friction(mean, std, *self._change_of(self._places[finger]))

    @property
    def learned_object(self) -> ObjectFriction | None:
        """What this grasp has learned of the object; None while it is unknown."""
        n, belief = len(self._places), self.memory.belief
        if not self.active or belief.version == 0.0:
            return None
        rows = [belief.p[i * BELIEF_ROW : i * BELIEF_ROW + n] for i in range(n)]
        std = math.sqrt(max(sum(map(sum, rows)), 0.0)) / n
        if not 0.0 < std <= self._settings.unknown:
            return None
        return ObjectFriction(sum(belief.mean[:n]) / n, std)

    def belief(self, finger: str) -> tuple[float, float]:
        i = self._places[finger]
        return believed_mean(self.memory, i), math.sqrt(believed_variance(self.memory, i))

    def _change_of(self, i: int) -> tuple[float, float, float]:
        g = self.memory
        return g.change.level[i], g.change.spread[i], g.probe.unknown


def share_friction(
    estimators: Mapping[str, object], settings: ControlSettings, known: ObjectFriction | None = None
) -> GraspFriction:
    """Return what fingers learn of friction together, from what their estimators believe now."""
    noise = getattr(settings, "noise", SensorNoise())
    estimator = getattr(settings, "estimator", EstimatorSettings())
    return GraspFriction(
        estimators,
        settings.friction,
        noise.tangential_force,
        estimator.friction_drift,
        known,
        noise.normal_force,
    )
