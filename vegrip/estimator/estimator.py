"""The online estimator of one fingertip: states in, contact, margin and health out. It never raises."""

import math
from dataclasses import replace
from functools import cache
from statistics import NormalDist

import numpy as np

from vegrip.errors import InputError
from vegrip.estimator.compiled import module_for
from vegrip.estimator.health import NO_CELL, HealthHysteresis, Look, health_of
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.layout import CHANNELS, FRICTION, Layout, layout_of, state_names
from vegrip.estimator.memory import REPORT_PLACE, EstimatorMemory
from vegrip.estimator.rewind_buffer import RewindBuffer
from vegrip.estimator.sample_clock import MemoryClock, SampleClock, Turn
from vegrip.estimator.saved_numbers import SavedNumbers
from vegrip.estimator.settings import EstimatorSettings, SensorNoise
from vegrip.messages import (
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
from vegrip.types import Floats, NamedNumbers

TANGENTIAL, TORQUE, SLIP = int(Channel.TANGENTIAL), int(Channel.TORQUE), int(Channel.SLIP)
CHANNEL_SETS = tuple(Channel(bits) for bits in range(64))
"""Every set of channels: joining two flags costs as much as a third of a filter step."""
SLIPS = 1.0
"""Value of the slip channel of a contact that slides; between 0 and this it says nothing."""
LOST = "lost"
"""Regime of a contact whose estimate contradicts its own measurement."""
LEAST_SLIP_SPEED = 2e-4
"""Of a sliding contact [m/s]; a slower one contradicts the slip channel."""


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
        self._module = module_for(model, self.layout, ellipse=self.settings.surface == "ellipse")
        self._memory = EstimatorMemory(self.layout, initial_memory(model, self.layout, noise, self.settings))
        self._clock: SampleClock | MemoryClock = SampleClock(self.settings)
        self._rewind = RewindBuffer(self.settings.late, self.layout.lasting)
        self._warm()
        self.reset()

    def reset(self) -> None:
        """Forget everything but the model: as before the first sample."""
        self._memory.reset()
        self._clock.reset()
        self._rewind.clear()
        self._margin, self._look = np.full(5, NAN), np.zeros(len(Look._fields))
        self._hysteresis = HealthHysteresis()
        self._followed = 0  # clocks that the hysteresis knows of
        self._health: ModelHealth | None = None  # the verdict at the last sample, once it was asked for,
        self._judged = -1  # and which one that was

    @property
    def memory(self) -> Floats:
        """All that is known, as plain numbers, shape (layout.size,); a copy, for :meth:`resume`."""
        return self._memory.numbers.copy()

    def resume(self, memory: Floats) -> None:
        """Go on from a :attr:`memory` that was kept, this estimator's or that of its export in C.

        For how long nothing was heard is not known: the next sample is taken as after a gap.

        Raises:
            InputError: it is of another model, or a number in it is none that a finger can have.

        """
        saved = SavedNumbers(self.model, self.layout)
        if memory.shape != (self.layout.size,) or not saved.are_legal(memory[saved.places]):
            raise InputError("these are not the numbers of a finger with this model")
        self.reset()
        saved.put_into(self._memory.numbers, memory[saved.places])
        self._clock.resume()

    def mount(self, memory: NamedNumbers, finger: str) -> None:
        """Lie in the ``memory`` of a finger from now on, whose step takes the samples.

        What is known moves there; :meth:`assimilate` is done by the step.
        """
        self._memory.move_to(memory.section("ESTIMATOR"))
        memory["TOLD_CONFIDENCE"] = self.settings.confidence
        if isinstance(self._clock, SampleClock):
            self._clock.write_to(memory)
            memory["SAMPLE_REWIND_NEXT"] = memory["SAMPLE_KEPT"] = 0
            if self.settings.late:
                self._rewind.write_to(memory)
        self._clock = MemoryClock(memory, finger)

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
        clock = self._clock
        assert isinstance(clock, SampleClock)  # noqa: S101 (the samples of a mounted one go to its finger)
        turn = clock.turn(state)
        if turn is Turn.NEXT:
            self._take(clock, state)
        elif turn is Turn.RESUMED or (not self._take_late(clock, state) and clock.refuse()):
            self._rewind.clear()
            clock.follow(state)
            self._take(clock, state)

    def _take_late(self, clock: SampleClock, state: FingertipState) -> bool:
        """Go back, take ``state``, and again those that came after it; return whether that is possible."""
        found = self._rewind.rewind(state.stamp)
        if found is None:
            return False
        lasting, before, later = found
        self._memory.numbers[: len(lasting)] = lasting
        clock.rewind(before, len(later))
        for sample in (state, *later):
            self._take(clock, sample)
        return True

    def _take(self, clock: SampleClock, state: FingertipState) -> None:
        """Take the sample that follows the last one."""
        memory = self._memory
        dt = clock.since_last(state)
        force, displacement, radius = state.normal_force, state.displacement, state.contact_radius
        usable = math.isfinite(force) or math.isfinite(displacement)
        if clock.taken is None and not usable:
            return
        if self.settings.late:
            self._rewind.note(state, clock.taken, memory.numbers)
        # not math.hypot: Python's rounds otherwise than C's
        x, y = state.tangential_force_x, state.tangential_force_y
        load = math.sqrt(x * x + y * y)
        load = clock.load = load if math.isfinite(load) else NAN
        torque = clock.torque = state.torque_z if math.isfinite(state.torque_z) else NAN
        memory.set_exogenous(state, load, torque)
        slip = _slip_of(state) if self.layout.mu_learned else NAN
        self._module.update(memory.numbers, dt, force, displacement, radius, load, torque, slip)
        clock.take(state, informs=usable and memory.is_informed)

    @property
    def late(self) -> int:
        """Samples that came late and were put in their place."""
        return self._clock.late

    @property
    def refused(self) -> int:
        """Samples refused because their stamp did not advance."""
        return self._clock.refused

    @property
    def in_contact(self) -> bool:
        """Whether the fingertip touches; made at two standard deviations, broken at half of one."""
        return self._clock.taken is not None and self._memory.has_contact

    @property
    def is_excited(self) -> bool:
        """Whether the tip moves in contact, or did within ``settings.learning_rest``: only then it learns."""
        return self.in_contact and self._memory.mode("REST") <= self.settings.learning_rest

    @property
    def normal_force(self) -> Estimate:
        """The normal force [N], one of the quantities of :meth:`contact_estimate`."""
        offered = self._clock.offered
        if self._clock.taken is None or offered is None:
            return UNKNOWN
        value, std = self._memory.report("FORCE"), self._memory.report("FORCE_STD")
        return Estimate(
            value, std, self._is_current() and math.isfinite(value + std), self._clock.age(offered)
        )

    def contact_estimate(self) -> ContactEstimate:
        """Return what is known of the contact since the last sample."""
        clock, state = self._clock, self._clock.offered
        if state is None:
            return ContactEstimate(0, "", 0)
        if clock.taken is None:
            return ContactEstimate(state.stamp, state.finger, clock.seq)
        known, at = self._memory.reports(), REPORT_PLACE
        age, current = clock.age(state), self._is_current()

        def of(name: str, *, when: bool = True) -> Estimate:
            value, std = known[at[name]], known[at[name + "_STD"]]
            return Estimate(value, std, current and when and math.isfinite(value + std), age)

        touching = known[at["CONTACT"]] > 0.5
        return ContactEstimate(
            state.stamp,
            state.finger,
            clock.seq,
            in_contact=touching,
            channels=self._channels_used() if clock.is_trusted else Channel.NONE,
            indentation=Estimate(known[at["DEPTH_NOW"]], known[at["DEPTH_STD"]], current, age),
            normal_force=of("FORCE"),
            contact_radius=of("RADIUS", when=known[at["RADIUS_SOUND"]] > 0.5),
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
        state = self._clock.taken
        if state is None:
            return SlipMargin(0, "", 0)
        memory, out = self._memory, self._margin
        self._module.margin_of(memory.numbers, self._clock.load, self._clock.torque, out)
        gauge, upper, reserve, when, earliest = out.tolist()
        relative, absolute = memory.report("GAUGE_REL"), memory.report("GAUGE_ABS")
        valid = self._is_valid() and self.in_contact and math.isfinite(upper)
        spread = gauge * relative
        std = math.sqrt(spread * spread + absolute * absolute)
        margin = Estimate(1.0 - gauge, std, valid, self._clock.age(state))
        if not valid:
            margin, upper, reserve, when, earliest = UNKNOWN, NAN, NAN, NAN, NAN
        return SlipMargin(
            state.stamp,
            state.finger,
            self._clock.seq,
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
        tangential, torque = (self._clock.load, self._clock.torque) if load is None else load
        return float(self._module.least_force(self._memory.numbers, tangential, torque, margin, at))

    @property
    def friction(self) -> tuple[float, float, float, float]:
        """Mean and variance of ln mu: now, and before the present loading."""
        return self._memory.friction

    def believe_friction(self, belief: tuple[float, float, float, float]) -> None:
        """Go on from another belief of friction, in the order of :attr:`friction`."""
        if self.layout.mu_learned:
            self._memory.friction = belief

    def utilisation(self) -> tuple[float, float, float]:
        """Return the friction coefficient at which the load would slip, its relative std, and the load [N].

        The load has the torque as a force at the contact radius. NaN and inf where there is no contact; the
        first two also while a part of the load is doubted (:mod:`vegrip.estimator.kernels.load_loss`).
        """
        report = self._memory.report
        gauge, radius = report("GAUGE"), report("RADIUS")
        if not (gauge > 0.0 and self._memory.has_contact and radius > 0.0):
            return NAN, math.inf, NAN
        mu = report("MU")
        friction_part = report("MU_STD") / mu if mu > 0.0 else 0.0
        known, noise = report("GAUGE_REL"), report("GAUGE_ABS") / gauge
        rest = max(known * known - friction_part * friction_part, 0.0)
        torque = 0.0 if math.isnan(self._clock.torque) else self._clock.torque / radius
        load = math.hypot(self._clock.load, torque)
        if self._memory.is_load_doubted:
            return NAN, math.inf, load
        return gauge * mu, math.sqrt(rest + noise * noise), load

    def health(self) -> ModelHealth:
        """Return whether the model still explains the measurements, and what it fails at most.

        The verdict has hysteresis over the stamps of the samples at which it is asked for; until the next
        sample it stays the same, and asking again costs nothing.
        """
        if self._health is None or self._judged != self._clock.offers:
            self._health, self._judged = self._assess(), self._clock.offers
        return self._health

    def _assess(self) -> ModelHealth:
        clock, memory = self._clock, self._memory
        if clock.followed != self._followed:
            self._followed = clock.followed
            self._hysteresis.follow_clock()
        if clock.taken is None:
            return ModelHealth(0, "", 0)
        condition = Condition.OK if self._channels_used() & 3 == 3 else Condition.DEGRADED
        if not self._is_valid():
            condition = Condition.STALE
        self._module.look_at_cells(memory.numbers, float(self._hysteresis.failing), self._look)
        health = health_of(clock.taken, clock.seq, condition, Look(*self._look.tolist()), self._hysteresis)
        if self.lost == 0.0:
            return health
        channel = CHANNELS[0 if memory.is_refused(CHANNELS[0]) else 1]
        return replace(health, consistent=False, channel=channel, regime=LOST)

    @property
    def lost(self) -> float:
        """For how long an estimate has contradicted its own measurement [s]; 0 while none does."""
        lost = self._memory.mode("LOST")
        return lost if lost > 0.0 else 0.0

    @property
    def restarts(self) -> int:
        """How often what is known of the contact was begun anew because it was lost."""
        return self._memory.count("RESTARTS")

    @property
    def overflows(self) -> int:
        """How often a number of the filter was not finite any more, and everything was begun anew."""
        return self._memory.count("OVERFLOWS")

    def reset_health(self) -> None:
        """Forget how well the model explained what was felt so far; what is known of the contact stays."""
        self._memory.reset_health()
        self._hysteresis, self._health = HealthHysteresis(), None

    def value(self, symbol: str) -> Estimate:
        """Return the present estimate of a parameter of the model; its std is that of the coordinate."""
        place = list(self.model.parameters).index(symbol)
        value = float(self._memory.section("VALUES")[place])
        if place == self.layout.mu:
            variance = float(self._memory.section("FRICTION")[FRICTION.index("VAR")])
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
        means = self._memory.means.tolist()
        variances = np.diag(self.covariance).tolist()
        offered = self._clock.offered
        age = math.inf if offered is None else self._clock.age(offered)
        current = self._is_current()
        estimates = (
            Estimate(mean, math.sqrt(max(variance, 0.0)), current, age)
            for mean, variance in zip(means, variances, strict=True)
        )
        return dict(zip(self.state_names, estimates, strict=True))

    @property
    def covariance(self) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """Covariance of the filter's state (delta, speed, effect states, learned, d0, bF); a copy."""
        return self._memory.covariance

    def _is_valid(self) -> bool:
        """Whether measurements come and are not all refused: only then an estimate counts."""
        taken = self._clock.taken
        if taken is None or not self._clock.age(taken) <= self.settings.longest_gap:
            return False
        return self._memory.is_sound

    def _is_current(self) -> bool:
        """Whether an estimate counts and contains the last sample offered."""
        return self._clock.is_trusted and self._is_valid()

    def _channels_used(self) -> Channel:
        bits = self._memory.used_bits()
        if self._clock.taken is not None:
            bits |= TANGENTIAL if math.isfinite(self._clock.load) else 0
            bits |= TORQUE if math.isfinite(self._clock.torque) else 0
            bits |= SLIP if math.isfinite(self._clock.taken.slip) else 0
        return CHANNEL_SETS[bits]

    def _warm(self) -> None:
        """Compile, or load from the cache, before the loop begins."""
        m = self._memory.blank.copy()
        for dt in (-1.0, 1e-3):
            self._module.update(m, dt, 0.0, 0.0, NAN, 0.0, 0.0, 0.0)
        self._module.margin_of(m, 0.0, 0.0, np.zeros(5))
        self._module.least_force(m, 0.0, 0.0, 0.1, 1.0)
        self._module.look_at_cells(m, float(NO_CELL), np.zeros(len(Look._fields)))


def _slip_of(state: FingertipState) -> float:
    """Return whether it slips; NaN where that is not sensed, or where the slip speed contradicts it."""
    if not math.isfinite(state.slip):
        return NAN
    if state.slip >= SLIPS and state.slip_speed < LEAST_SLIP_SPEED:  # NaN is not
        return NAN
    return state.slip


@cache
def quantile(confidence: float) -> float:
    """Return the standard normal quantile; asked at every sample, for few values."""
    return NormalDist().inv_cdf(min(max(confidence, 1e-9), 1.0 - 1e-9))
