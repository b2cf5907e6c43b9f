"""What all fingers of a grasp learn of friction together: how it begins, and what is said of it.

Before a finger takes a state, its step (:mod:`vegrip.grip.kernels.friction_shared`) receives what its
channels say of slip (:mod:`.slip_channels`), writes what the grasp believes of its friction
(:mod:`.friction_belief`) into its estimate, and chooses margin and confidence. Afterwards it takes in what
the load shows (:mod:`.slip_witness`) and decides what is assumed and lowered (:mod:`.force_release`).
"""

import math
from collections.abc import Mapping
from dataclasses import replace

from vegrip.errors import ConfigError
from vegrip.estimator.estimator import ContactEstimator
from vegrip.estimator.settings import SensorNoise
from vegrip.grip.drive_lag import begin_drives, measured_lag, set_drives
from vegrip.grip.force_release import *
from vegrip.grip.grasp_memory import BELIEF_MOST, GraspMemory
from vegrip.grip.known_objects import ObjectFriction
from vegrip.grip.load_lead import begin_lead
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import KNOWN, PROBED, ContactEstimate, Estimate, ModelHealth
from vegrip.types import NamedNumbers

CHANNELS_OF_SLIP = ("slip", "slip_speed")
LATEST_DRIVE = (BLIND - RISE) / QUICK
"""[s] lag of a drive from which on the load is no witness of a slide."""
UNKNOWN_OBJECT = CREDIBLE * SCATTER
"""Std of ln mu below which friction is reported as known: a slide or two would tell as much."""


class GraspFriction:
    """Friction of the contacts of one object.

    Args:
        fingers: the estimator of each, by name; one of another make makes all learn alone.
        settings: how friction is learned, and what grip it is for.
        known: what former grasps have learned of the object.

    """

    def __init__(
        self,
        fingers: Mapping[str, object],
        settings: ControlSettings,
        known: ObjectFriction | None = None,
    ) -> None:
        able = {name: e for name, e in fingers.items() if isinstance(e, ContactEstimator)}
        self._settings = settings.friction
        self._noise = next((e.noise for e in fingers.values() if hasattr(e, "noise")), SensorNoise())
        self.active = self._settings.learning and len(able) == len(fingers)
        self._places = {name: i for i, name in enumerate(fingers)}
        self.memory = GraspMemory(len(fingers))
        """All that the fingers of the grasp share; their steps write here."""
        begin_drives(self.memory, self._noise.normal_force)
        if self.active:
            self._begin(able, known)
        self.set_risk(settings.grip)
        self.set_lead(settings.grip)

    def _begin(self, able: Mapping[str, ContactEstimator], known: ObjectFriction | None) -> None:
        s, g = self._settings, self.memory
        begin_belief(g, len(able), max(e.settings.friction_drift for e in able.values()))
        widest = 0.0
        if known is not None and not known.is_plausible:
            raise ConfigError(f"what is known of the object is {known}: give ln mu within 2, its std below 2")
        for i, estimator in enumerate(able.values()):
            mean, variance, exponent, exponent_var = estimator.friction_law
            widest = max(widest, variance)
            if known is not None and known.prior[1] ** 2 < variance:
                mean, variance = known.prior[0], known.prior[1] ** 2
                g.belief.version = 1.0
            if variance > 0.0:  # else it is stated, and not learned
                expect_exponent(g, exponent, exponent_var)
            expect_finger(g, i, mean, math.sqrt(max(variance, 0.0)), s.own_spread)
        g.belief.prior_var = widest  # forgetting leads back to what is usual
        begin_channels(g, s.sliding_speed, s.slip_delay)
        begin_witness(g, self._noise.tangential_force)
        begin_release(g)

    def set_risk(self, grip: GripSettings) -> None:
        """Set what the grip risks."""
        if self.active:
            is_fine = not self._settings.why_too_coarse
            set_risk(self.memory, 1.0 - grip.probability, 1.0 - grip.known_probability, is_fine)

    def set_lead(self, grip: GripSettings) -> None:
        """Set what is stated of the drives; what was measured stays."""
        self._is_leading = self.active or grip.drive_lag > 0.0
        set_drives(self.memory, grip.drive_lag, grip.burst_rate)
        begin_lead(self.memory, self._noise.tangential_force, self._noise.torque_z)

    def drive_lag(self, finger: str) -> float:
        """Return the measured lag of the drive of ``finger`` [s]; NaN while it is not known."""
        i = self._places[finger]
        return measured_lag(self.memory, i) if i < BELIEF_MOST else math.nan

    def write_to(self, memory: NamedNumbers, finger: str) -> None:
        """Let the step of a finger know what is set."""
        i = self._places[finger]
        memory["SETUP_SHARES"] = self.active
        memory["SETUP_LEADS"] = self._is_leading and i < BELIEF_MOST
        memory["SHARED_LOAD_NOISE"] = self._noise.tangential_force

    @property
    def why_not_probing(self) -> str:
        """Why force is not lowered to learn friction; empty while it is."""
        if not self.active:
            return "friction is not learned"
        if self._settings.why_too_coarse:
            return self._settings.why_too_coarse
        return next(filter(None, map(self._why_not_received, self._places)), "")

    def _why_not_received(self, finger: str) -> str:
        g, i = self.memory, self._places[finger]
        if found := self.suspicion(finger):
            return found
        if math.isnan(g.slip.says[i]) and math.isnan(g.slip.says[BELIEF_MOST + i]):
            return f"{finger} does not feel slip"
        late = slowest_drive(g)
        if chance_noticed(g) < SURE and late > LATEST_DRIVE:
            return (
                f"a drive lags by {late:.3f} s, {LATEST_DRIVE:g} s is the most until a slip channel has"
                " reported a slide: by the load it would be seen too late"
            )
        if sound_channel(g, i) < SURE:
            return f"the slip channel of {finger} has not reported a slide yet, and may be dead"
        return ""

    def doubted_channel(self, finger: str) -> str:
        """Return which channel of ``finger`` is surely not sound; empty = none."""
        if not self.active:
            return ""
        at = self._doubted(finger)
        return CHANNELS_OF_SLIP[at >= BELIEF_MOST] if at >= 0 else ""

    def _doubted(self, finger: str) -> int:
        """Return the place of the channel of ``finger`` that is not sound; -1: there is none."""
        flag = self._places[finger]
        return next((at for at in (flag, BELIEF_MOST + flag) if is_unsound(self.memory, at)), -1)

    def suspicion(self, finger: str) -> str:
        """Return what is wrong with what ``finger`` feels of slip, in a sentence; empty while all is well."""
        channel = self.doubted_channel(finger)
        if not channel:
            return ""
        is_faulty = faulty(self.memory, self._doubted(finger)) > EVEN
        wrong = (
            "says slip while its load shows none" if is_faulty else "is silent in a slide that its load shows"
        )
        return f"the channel '{channel}' of {finger} {wrong}, and is not used"

    def friction_counted_on(self, finger: str) -> str:
        """Return how ``finger`` takes friction: PROBED, KNOWN, or "" for what is usual."""
        if not self.active:
            return ""
        g, i = self.memory, self._places[finger]
        if g.release.shift[i] > RISE:
            return PROBED
        return KNOWN if believed_variance(g, i) < UNKNOWN_OBJECT**2 and chance_noticed(g) >= SURE else ""

    def report_unsound(self, health: ModelHealth) -> ModelHealth:
        """Return ``health`` with the channel that is not sound, instead of what the model fails at.

        What the grip assumes of friction is in it, too.
        """
        channel, friction = self.doubted_channel(health.finger), self.friction_counted_on(health.finger)
        if channel:
            return replace(health, channel=channel, regime="", suspect="", friction=friction)
        return health if friction == health.friction else replace(health, friction=friction)

    def state_friction(self, contact: ContactEstimate) -> ContactEstimate:
        """Return ``contact`` with the friction that is stated: it may have changed since it was felt."""
        mu = contact.friction_coefficient
        if not (self.active and contact.finger in self._places and 0.0 < mu.value < math.inf):
            return contact
        std = mu.value * stated_std(mu.std / mu.value)
        return replace(contact, friction_coefficient=Estimate(mu.value, std, mu.valid, mu.age))

    def stated_friction(self, mean: float, std: float) -> tuple[float, float]:
        """Return mean and standard deviation of ln mu that are stated where these are believed."""
        return mean, stated_std(std) if self.active else std

    @property
    def learned_object(self) -> ObjectFriction | None:
        """What this grasp believes of the object over its time; None: no more than at first."""
        belief = self.memory.belief
        variance = belief.usual_square - belief.usual**2
        if not (self.active and 0.0 < variance < belief.prior_var - NEARLY_NONE):
            return None
        return ObjectFriction(belief.usual, math.sqrt(variance))

    def belief(self, finger: str) -> tuple[float, float]:
        """Return mean and std of ln mu of ``finger`` at its present load."""
        i = self._places[finger]
        return believed_mean(self.memory, i), math.sqrt(believed_variance(self.memory, i))
