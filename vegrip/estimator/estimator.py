"""The online estimator of one fingertip: states in, contact, margin and health out. It never raises."""

import math
import struct
from functools import cache
from statistics import NormalDist

import numpy as np

from vegrip.clock import NS
from vegrip.errors import InputError
from vegrip.estimator.compiled import module_for
from vegrip.estimator.friction_prior import FrictionBelief
from vegrip.estimator.health import NO_CELL, HealthHysteresis, Look
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import (
    CHANNELS,
    FRICTION,
    PER_CHANNEL,
    REGIMES,
    REPORT,
    Layout,
    layout_of,
    state_names,
)
from vegrip.estimator.memory import CHANNELS as MEASURED
from vegrip.estimator.memory import FingerMemory, SampleLayout
from vegrip.estimator.saved_numbers import SavedNumbers
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.messages import (
    BEYOND_FIT,
    NAN,
    UNKNOWN,
    Channel,
    Condition,
    ContactEstimate,
    Estimate,
    FingertipState,
    ModelHealth,
    SlipMargin,
)
from vegrip.model import ContactModel
from vegrip.model.native import bound_call
from vegrip.types import Floats

TANGENTIAL, TORQUE, SLIP = int(Channel.TANGENTIAL), int(Channel.TORQUE), int(Channel.SLIP)
CHANNEL_SETS = tuple(Channel(bits) for bits in range(64))
"""Every set of channels: joining two flags costs as much as a third of a filter step."""
LOST = "lost"
"""Regime of a contact whose estimate contradicts its own measurement."""
BEYOND_STDS, BEYOND_SHARE = 2.0, 1.25
"""By so many standard deviations a quantity is beyond so many times the range over which a model was fitted,
before it is said."""
REPORT_PLACE = {name: i for i, name in enumerate(REPORT)}
CHANNEL_BITS = (int(Channel.POSITION), int(Channel.FORCE), int(Channel.RADIUS))
"""Bit of each of :data:`~vegrip.estimator.layout.CHANNELS`."""
FARTHEST = (1 << 63) - 1
"""[ns] A stamp beyond counts as this one."""


class ContactEstimator:
    """Recursive estimate of one contact, with standard deviations.

    It works with force and displacement, with either alone (:attr:`ContactEstimate.channels` says which it
    had), with any spacing of the samples, and through making and breaking contact. Force alone leaves the
    indentation as uncertain as the stiffness; displacement alone leaves the force so.

    Args:
        model: the contact model; its parameters' standard deviations are the prior.
        noise: white noise of the sensors.
        settings: how it behaves.

    """

    def __init__(
        self, model: ContactModel, noise: SensorNoise, settings: EstimatorSettings | None = None
    ) -> None:
        self.model, self.noise = model, noise
        self.settings = settings if settings is not None else EstimatorSettings()
        self.layout: Layout = layout_of(model)
        self._module = module_for(
            model, self.layout, late=self.settings.late, ellipse=self.settings.surface == "ellipse"
        )
        self._blank = initial_memory(model, self.layout, noise, self.settings)
        self._used = tuple(self.layout.channel_place(i, "USED") for i in range(len(CHANNELS)))
        self._pack = struct.Struct(f"={len(MEASURED)}d").pack_into
        self._finger = ""
        self._lie_in(FingerMemory(SampleLayout(self.layout, self.settings.late)))
        self.named["CLOCK_RECOVERY"] = self.settings.recovery
        self.named["CLOCK_GAP"] = round(self.settings.longest_gap * NS) + 1
        self._warm()
        self.reset()

    def _lie_in(self, memory: FingerMemory) -> None:
        self.named = memory
        """All its numbers by name, those of the clock among them."""
        self.numbers: Floats = memory.section("ESTIMATOR")
        """What the filter works on, shape (layout.size,)."""
        self._wholes, self._stamp = memory.t.data, memory.layout.wholes["NEWS_STAMP"]
        self._state = memory.section("STATE").data.cast("B")
        self._take = bound_call(self._module, "assimilate", memory.f, memory.t)

    def reset(self) -> None:
        """Forget everything but the model: as before the first sample."""
        memory = self.named
        self.numbers[:] = self._blank
        memory.section("SAMPLE")[:] = 0
        memory["TAKEN_LOAD"] = memory["TAKEN_TORQUE"] = memory["TAKEN_SLIP"] = NAN
        self._margin, self._look = np.full(5, NAN), np.zeros(len(Look._fields))
        self._hysteresis = HealthHysteresis()
        self._followed = 0  # clocks that the hysteresis knows of
        self._health: ModelHealth | None = None  # the verdict at the last sample, once it was asked for,
        self._judged = -1  # and which one that was

    @property
    def memory(self) -> Floats:
        """All that is known, as plain numbers, shape (layout.size,); a copy, for :meth:`resume`."""
        return self.numbers.copy()

    def resume(self, memory: Floats) -> None:
        """Go on from a :attr:`memory` that was kept, this estimator's or that of its export in C.

        How long the silence was is not known: the next sample is taken as after a gap.

        Raises:
            InputError: it is of another model, or a number in it is none that a finger can have.

        """
        saved = SavedNumbers(self.model, self.layout)
        if memory.shape != (self.layout.size,) or not saved.are_legal(memory[saved.places]):
            raise InputError("these are not the numbers of a finger with this model")
        self.reset()
        saved.put_into(self.numbers, memory[saved.places])
        self.named["SAMPLE_RESUMED"] = 1

    def mount(self, memory: FingerMemory, finger: str) -> None:
        """Lie in the ``memory`` of a ``finger`` from now on, whose step takes the samples.

        What is known moves there; the state that is in it stays.
        """
        memory.take_over(self.named, ("STATE", "NEWS"))
        self._finger = finger
        self._lie_in(memory)

    def update(self, state: FingertipState) -> ContactEstimate:
        """Take one sample and return what is known now: :meth:`assimilate`, then :meth:`contact_estimate`."""
        self.assimilate(state)
        return self.contact_estimate()

    def assimilate(self, state: FingertipState) -> None:
        """Take one sample.

        A sample that comes late, at most ``settings.late`` samples after its turn, takes its place among the
        others (a camera's radius, say, which is some frames old). A stamp that was there already, or older
        still, is refused and counted (:attr:`refused`), and what is known is not trusted until the next one;
        after ``settings.recovery`` of them in a row the sender's clock is taken to have started anew after a
        gap, and what is known of the contact is carried over it. Values that are not finite count as not
        measured.
        """
        self._pack(
            self._state, 0, state.normal_force, state.tangential_force_x, state.tangential_force_y,
            state.torque_z, state.displacement, state.temperature, state.slip, state.slip_speed,
            state.contact_radius,
        )  # fmt: skip
        self._wholes[self._stamp] = min(max(state.stamp, -FARTHEST), FARTHEST)
        self._finger = state.finger
        self._take()

    @property
    def late(self) -> int:
        return int(self.named["SAMPLE_LATE"])

    @property
    def refused(self) -> int:
        """Samples refused because their stamp did not advance."""
        return int(self.named["SAMPLE_REFUSED"])

    @property
    def in_contact(self) -> bool:
        """Whether the fingertip touches; made at two standard deviations, broken at half of one."""
        return self._has_begun and bool(self.named["REP_CONTACT"] > 0.0)

    @property
    def is_excited(self) -> bool:
        """Whether the tip moves in contact, or did within ``settings.learning_rest``: only then it learns."""
        return self.in_contact and bool(self.named["MODE_REST"] <= self.settings.learning_rest)

    @property
    def normal_force(self) -> Estimate:
        """The normal force [N], one of the quantities of :meth:`contact_estimate`."""
        memory = self.named
        if not self._has_begun:
            return UNKNOWN
        value, std = memory["REP_FORCE"], memory["REP_FORCE_STD"]
        return Estimate(value, std, self._is_current() and math.isfinite(value + std), self._age())

    def contact_estimate(self) -> ContactEstimate:
        """Return what is known of the contact since the last sample."""
        memory = self.named
        if not (self._has_begun or memory["SAMPLE_OFFERED"]):
            return ContactEstimate(0, "", 0)
        stamp, seq = memory["SAMPLE_SHOWN"], memory["SAMPLE_SEQ"]
        if not self._has_begun:
            return ContactEstimate(stamp, self._finger, seq)
        # a dict of them would cost a fifth of a contact estimate
        known, at = memory.section("REPORT").tolist(), REPORT_PLACE
        age, current = self._age(), self._is_current()

        def of(name: str, *, when: bool = True) -> Estimate:
            value, std = known[at[name]], known[at[name + "_STD"]]
            return Estimate(value, std, current and when and math.isfinite(value + std), age)

        touching = known[at["CONTACT"]] > 0.0
        return ContactEstimate(
            stamp,
            self._finger,
            seq,
            in_contact=touching,
            channels=self._channels_used() if memory["SAMPLE_TRUSTED"] else Channel.NONE,
            indentation=Estimate(known[at["DEPTH_NOW"]], known[at["DEPTH_STD"]], current, age),
            normal_force=of("FORCE"),
            contact_radius=of("RADIUS", when=known[at["RADIUS_SOUND"]] > 0.0),
            pressure_exponent=of("EXPONENT", when=touching),
            friction_coefficient=of("MU"),
            limit_force=of("LIMIT_FORCE"),
            limit_torque=of("LIMIT_TORQUE"),
            limit_radius=of("LIMIT_RADIUS", when=touching),
        )

    def slip_margin(self) -> SlipMargin:
        """Return the margin for the load of the last sample, its bound, and what the present hold leads to.

        Out of contact, or without a measured tangential force, nothing is valid and the numbers are NaN. A
        torque that is not measured counts as zero.
        """
        if not self._has_begun:
            return SlipMargin(0, "", 0)
        memory, out = self.named, self._margin
        stamp = memory["SAMPLE_STAMP"]
        self._module.margin_of(self.numbers, memory["TAKEN_LOAD"], memory["TAKEN_TORQUE"], out)
        gauge, upper, reserve, when, earliest = out.tolist()
        relative, absolute = memory["REP_GAUGE_REL"], memory["REP_GAUGE_ABS"]
        valid = self._is_valid() and self.in_contact and math.isfinite(upper)
        spread = gauge * relative
        std = math.sqrt(spread * spread + absolute * absolute)
        margin = Estimate(1.0 - gauge, std, valid, self._age("SAMPLE_STAMP"))
        if not valid:
            margin, upper, reserve, when, earliest = UNKNOWN, NAN, NAN, NAN, NAN
        return SlipMargin(
            stamp,
            self._finger,
            memory["SAMPLE_SEQ"],
            margin=margin,
            lower_bound=1.0 - upper,
            confidence=self.settings.confidence,
            force_reserve=reserve,
            time_to_slip=when,
            earliest_slip=earliest,
        )

    def least_force(
        self, margin: float, confidence: float | None = None, load: tuple[float, float] | None = None
    ) -> float:
        """Return the least normal force [N] with which the margin's lower bound stays at ``margin``.

        For the load of the last sample or the given one (tangential force [N], torque [N m]), at
        ``confidence`` (one-sided; else ``settings.confidence``), now and over ``settings.horizon`` of the
        hold in ``settings.hold``. NaN when the load or the contact is not known, inf when no force suffices.
        """
        if not self._is_valid():
            return NAN
        at = quantile(self.settings.confidence if confidence is None else confidence)
        memory = self.named
        tangential, torque = (memory["TAKEN_LOAD"], memory["TAKEN_TORQUE"]) if load is None else load
        return float(self._module.least_force(self.numbers, tangential, torque, margin, at))

    @property
    def friction(self) -> tuple[float, float]:
        """Mean and variance of ln mu at the present normal force, as the tangential channels show it."""
        m = self.named
        load = m["FRI_LOAD"]
        variance = m["FRI_VAR"] - 2.0 * load * m["FRI_COV"] + load * load * m["FRI_EXPONENT_VAR"]
        return m["FRI_LN_MU"] - load * m["FRI_EXPONENT"], variance

    @property
    def friction_law(self) -> FrictionBelief:
        """What is believed of ln mu at the reference load, and of the exponent over the load."""
        m = self.named
        return FrictionBelief(m["FRI_LN_MU"], m["FRI_VAR"], m["FRI_EXPONENT"], m["FRI_EXPONENT_VAR"])

    def health(self) -> ModelHealth:
        """Return whether the model still explains the measurements, and what it fails at most.

        The verdict has hysteresis over the stamps of the samples at which it is asked for; until the next
        sample it stays the same, and asking again costs nothing.
        """
        offered = self.named["SAMPLE_OFFERED"]
        if self._health is None or self._judged != offered:
            self._health, self._judged = self._assess(), offered
        return self._health

    def _assess(self) -> ModelHealth:
        memory = self.named
        if memory["SAMPLE_FOLLOWED"] != self._followed:
            self._followed = memory["SAMPLE_FOLLOWED"]
            self._hysteresis.follow_clock()
        if not self._has_begun:
            return ModelHealth(0, "", 0)
        condition = Condition.OK if self._channels_used() & 3 == 3 else Condition.DEGRADED
        if not self._is_valid():
            condition = Condition.STALE
        self._module.look_at_cells(self.numbers, float(self._hysteresis.failing), self._look)
        stamp, look = memory["SAMPLE_STAMP"], Look(*self._look.tolist())
        failing = self._hysteresis.update(int(look.worst), look.misfit, look.reported_misfit, stamp)
        channel = regime = ""
        if self.lost > 0.0:
            channel, regime = CHANNELS[0 if memory["DISPLACEMENT_STREAK"] > 0.0 else 1], LOST
        elif failing != NO_CELL:
            channel, regime = CHANNELS[failing // len(REGIMES)], REGIMES[failing % len(REGIMES)]
        explains = look.judged > 0.0 and not channel
        if not channel and (channel := self._beyond()):
            regime = BEYOND_FIT
        return ModelHealth(
            stamp, self._finger, memory["SAMPLE_SEQ"], condition, look.nis, explains, channel, regime,
            rejected=int(look.rejected),
        )  # fmt: skip

    def _beyond(self) -> str:
        """Return the channel of what is surely beyond the range over which the model was fitted, or ""."""
        shown, m = self.model.shown, self.named
        temperature = float(m.section("EXOGENOUS")[0])
        if not shown.coldest <= temperature <= shown.warmest:
            return "temperature"
        if not m["REP_CONTACT"] > 0.0 or not m["REP_SOUND"] > 0.0:
            return ""
        speed_std = math.sqrt(max(m["MOTION_VAR_SPEED"], 0.0))
        for channel, value, std, most in (
            ("displacement", m["REP_DEPTH_NOW"], m["REP_DEPTH_STD"], shown.depth),
            ("displacement", abs(m["MOTION_SPEED"]), speed_std, shown.speed),
            ("normal_force", m["REP_FORCE"], m["REP_FORCE_STD"], shown.load),
        ):
            if value - BEYOND_STDS * std > BEYOND_SHARE * most:
                return channel
        return ""

    @property
    def lost(self) -> float:
        """For how long an estimate has contradicted its own measurement [s]; 0 while none does."""
        lost = self.named["MODE_LOST"]
        return float(lost) if lost > 0.0 else 0.0

    def reset_health(self) -> None:
        """Forget how well the model explained what was felt so far; what is known of the contact stays."""
        self.named.section("HEALTH")[:] = 0.0
        rejected = PER_CHANNEL.index("REJECTED")
        self.named.section("CHANNEL").reshape(len(CHANNELS), -1)[:, rejected] = 0.0
        self._hysteresis, self._health = HealthHysteresis(), None

    def value(self, symbol: str) -> Estimate:
        """Return the present estimate of a parameter of the model; its std is that of the coordinate."""
        place = list(self.model.parameters).index(symbol)
        value = float(self.named.section("VALUES")[place])
        if place == self.layout.mu:
            variance = float(self.named.section("FRICTION")[FRICTION.index("VAR")])
        elif place in self.layout.learned:
            j = self.layout.learned_from + self.layout.learned.index(place)
            variance = float(self.covariance[j, j])
        else:
            variance = self.model.values[symbol].std ** 2
        return Estimate(value, math.sqrt(variance), self._is_valid(), 0.0)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the filter's state, in the order of :attr:`covariance`.

        ``indentation`` [m], ``speed`` [m/s], states of the effects, each learned parameter (``ln K`` where
        it is learned in its logarithm), ``displacement_offset`` [m] and ``force_bias`` [N].
        """
        return state_names(self.model, self.layout)

    @property
    def state(self) -> dict[str, Estimate]:
        """The filter's state by :attr:`state_names`, each with the spread that the covariance says."""
        means = self.named.section("Y").tolist()
        variances = np.diag(self.covariance).tolist()
        age = self._age()
        current = self._is_current()
        estimates = (
            Estimate(mean, math.sqrt(max(variance, 0.0)), current, age)
            for mean, variance in zip(means, variances, strict=True)
        )
        return dict(zip(self.state_names, estimates, strict=True))

    @property
    def covariance(self) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """Covariance of the filter's state (delta, speed, effect states, learned, d0, bF); a copy."""
        n = self.layout.n
        return self.named.section("P").reshape(n, n).copy()

    def _is_valid(self) -> bool:
        if not self._has_begun or not self._age("SAMPLE_STAMP") <= self.settings.longest_gap:
            return False
        return bool(self.named["REP_SOUND"] > 0.0)

    def _is_current(self) -> bool:
        return bool(self.named["SAMPLE_TRUSTED"]) and self._is_valid()

    @property
    def _has_begun(self) -> bool:
        return bool(self.named["SAMPLE_BEGUN"])

    def _age(self, at: str = "SAMPLE_SHOWN") -> float:
        """Return how old [s] the last sample that informed is at a stamp; inf when there was none."""
        memory = self.named
        return (memory[at] - memory["SAMPLE_INFORMED"]) / NS if memory["SAMPLE_IS_INFORMED"] else math.inf

    def _channels_used(self) -> Channel:
        memory, numbers = self.named, self.numbers
        used = zip(self._used, CHANNEL_BITS, strict=True)
        bits = sum(bit for place, bit in used if numbers[place] > 0.0)
        if self._has_begun:
            bits |= TANGENTIAL if math.isfinite(memory["TAKEN_LOAD"]) else 0
            bits |= TORQUE if math.isfinite(memory["TAKEN_TORQUE"]) else 0
            bits |= SLIP if math.isfinite(memory["TAKEN_SLIP"]) else 0
        return CHANNEL_SETS[bits]

    def _warm(self) -> None:
        m = self._blank.copy()
        for dt in (-1.0, 1e-3):
            self._module.update(m, dt, 0.0, 0.0, NAN, 0.0, 0.0, 0.0)
        self._module.margin_of(m, 0.0, 0.0, np.zeros(5))
        self._module.least_force(m, 0.0, 0.0, 0.1, 1.0)
        self._module.look_at_cells(m, float(NO_CELL), np.zeros(len(Look._fields)))
        self._take()


@cache
def quantile(confidence: float) -> float:
    """Return the standard normal quantile; asked at every sample, for few values."""
    return NormalDist().inv_cdf(min(max(confidence, 1e-9), 1.0 - 1e-9))
