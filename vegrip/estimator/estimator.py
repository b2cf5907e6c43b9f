"""The online estimator of one fingertip: states in, contact, margin and health out. It never raises."""

import math
from dataclasses import replace
from functools import cache
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.errors import InputError
from vegrip.estimator.compiled import module_for
from vegrip.estimator.health import Watch, health_of
from vegrip.estimator.initial_state import blank
from vegrip.estimator.layout import CHANNELS, COUNTS, FRICTION, MODE, PER_CHANNEL, REPORT, Layout, layout_of
from vegrip.estimator.rewind_buffer import Past
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
from vegrip.types import NamedNumbers

FLAGS = (int(Channel.POSITION), int(Channel.FORCE), int(Channel.RADIUS))
TANGENTIAL, TORQUE, SLIP = int(Channel.TANGENTIAL), int(Channel.TORQUE), int(Channel.SLIP)
CHANNEL_SETS = tuple(Channel(bits) for bits in range(64))
"""Every set of channels: joining two flags costs as much as a third of a filter step."""
SLIPS = 0.5
"""Value of the slip channel from which the contact slides."""
LOST = "lost"
"""Regime of a contact whose estimate contradicts its own measurement."""
LEAST_SLIP_SPEED = 2e-4
"""Of a sliding contact [m/s]; a slower one contradicts the slip channel."""
R = {name: i for i, name in enumerate(REPORT)}


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
        self._places = {name: slice(*place) for name, place in self.layout.places().items()}
        self._past = Past(self.settings.late, self.layout.size)
        self._used_places = tuple(self.layout.channel_place(i, "USED") for i in range(len(CHANNELS)))
        self._report_start = self._places["REPORT"].start
        self._blank = blank(model, self.layout, noise, self.settings)
        self._warm()
        self.reset()

    def reset(self) -> None:
        """Forget everything but the model: as before the first sample."""
        self._m = self._blank.copy()
        self._margin = np.full(5, NAN)
        self._state: FingertipState | None = None
        self._tangential = self._torque = NAN
        self._informed = NAN  # stamp of the last sample that said something about the contact
        self._seq = 0
        self.refused = 0
        """Samples refused because their stamp did not advance."""
        self.late = 0
        """Samples that came late and were put in their place."""
        self._backwards = 0
        self._resumed = False  # whether the memory is one that was kept
        self._past.clear()
        self._watch = Watch()
        self._health: ModelHealth | None = None  # the verdict at the last sample, once it was asked for
        self._shown: FingertipState | None = None  # the last sample offered, taken or not
        self._trusted = False  # whether it was taken

    @property
    def memory(self) -> NDArray[np.float64]:
        """All that is known, as plain numbers, shape (layout.size,); a copy, for :meth:`resume`."""
        return self._m.copy()

    def resume(self, memory: NDArray[np.float64]) -> None:
        """Go on from a :attr:`memory` that was kept, this estimator's or that of its export in C.

        For how long nothing was heard is not known: the next sample is taken as after a gap.

        Raises:
            InputError: it is of another model, or the state, covariance or values in it are not finite.

        """
        known = self._places["VALUES"].stop
        if memory.shape != (self.layout.size,) or not np.isfinite(memory[:known]).all():
            raise InputError("these are not the numbers of a finger with this model")
        self.reset()
        self._m[:] = memory
        self._resumed = True

    def write_to(self, memory: NamedNumbers) -> None:
        """Lend everything to the compiled finger step: from now on ``memory`` is where it lies."""
        lent = memory.section("ESTIMATOR")
        if self._m.ctypes.data != lent.ctypes.data:
            lent[:] = self._m
            self._m = lent
        if self.settings.late:
            self._past.lie_in(memory.section("REWIND").reshape(self.settings.late, -1))
            memory["SAMPLE_REWIND_NEXT"] = self._past.next_slot
        state, shown = self._state, self._shown
        memory["TAKEN_LOAD"], memory["TAKEN_TORQUE"] = self._tangential, self._torque
        memory["SAMPLE_BEGUN"], memory["SAMPLE_STAMP"] = state is not None, state.stamp if state else 0
        informed = self._informed == self._informed
        memory["SAMPLE_IS_INFORMED"], memory["SAMPLE_INFORMED"] = informed, self._informed if informed else 0
        memory["SAMPLE_SHOWN"], memory["SAMPLE_TRUSTED"] = shown.stamp if shown else 0, self._trusted
        memory["SAMPLE_SEQ"], memory["SAMPLE_RESUMED"] = self._seq, self._resumed
        memory["SAMPLE_REFUSED"], memory["SAMPLE_BACKWARDS"] = self.refused, self._backwards
        memory["SETUP_RECOVERY"] = self.settings.recovery
        memory["SETUP_GAP"] = round(self.settings.longest_gap * NS) + 1

    def read_from(self, memory: NamedNumbers, taken: list[FingertipState]) -> None:
        """Take what the compiled finger step has made of the states ``taken`` since :meth:`write_to`."""
        if not taken:
            return
        if self.settings.late:
            self._past.taken(taken, self._state)
        self._state = self._shown = taken[-1]
        self._health = None
        self._tangential, self._torque = memory["TAKEN_LOAD"], memory["TAKEN_TORQUE"]
        self._informed = int(memory["SAMPLE_INFORMED"]) if memory["SAMPLE_IS_INFORMED"] else NAN
        self._trusted, self._seq = bool(memory["SAMPLE_TRUSTED"]), int(memory["SAMPLE_SEQ"])
        self._backwards = int(memory["SAMPLE_BACKWARDS"])

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
        self._shown, self._trusted, self._health = state, False, None
        if self._resumed:
            self._resumed = False
            self._follow_clock(state, state)
            return
        last = self._state
        if last is not None and state.stamp <= last.stamp:
            if self._late(state):
                return
            self.refused += 1
            self._backwards += 1
            if self._backwards >= self.settings.recovery:
                self._follow_clock(last, state)
            return
        self._backwards = 0
        self._take(state)

    def _follow_clock(self, last: FingertipState, state: FingertipState) -> None:
        """Take ``state``, the next after ``last`` but by a clock that has started anew.

        The silence has an unknown length: it is taken as the time after which the motion counts as unknown.
        """
        self._backwards = 0
        self._past.clear()
        self._watch.follow_clock()
        gap = round(self.settings.longest_gap * NS) + 1
        self._state = replace(last, stamp=state.stamp - gap)
        self._informed = state.stamp - gap
        self._take(state)

    def _late(self, state: FingertipState) -> bool:
        """Go back, take ``state``, and again those that came after it."""
        found = self._past.rewind(state.stamp)
        if found is None:
            return False
        self._m[:], self._state, later = found
        self._seq -= len(later)
        for sample in (state, *later):
            self._take(sample)
        self.late += 1
        return True

    def _take(self, state: FingertipState) -> None:
        """Take the sample that follows the last one."""
        last = self._state
        dt = -1.0 if last is None else (state.stamp - last.stamp) / NS
        force, displacement, radius = state.normal_force, state.displacement, state.contact_radius
        usable = math.isfinite(force) or math.isfinite(displacement)
        if last is None and not usable:
            return
        if self.settings.late:
            self._past.note(state, last, self._m)
        self._state, self._trusted = state, True
        # not math.hypot: Python's rounds otherwise than C's
        x, y = state.tangential_force_x, state.tangential_force_y
        self._tangential = math.sqrt(x * x + y * y)
        if not math.isfinite(self._tangential):
            self._tangential = NAN
        self._torque = state.torque_z if math.isfinite(state.torque_z) else NAN
        self._outside(state)
        slip = _slip_of(state) if self.layout.mu_learned else NAN
        self._module.update(self._m, dt, force, displacement, radius, self._tangential, self._torque, slip)
        if usable and self._used_any():
            self._informed = state.stamp
        self._seq += 1

    @property
    def in_contact(self) -> bool:
        """Whether the fingertip touches; made at two standard deviations, broken at half of one."""
        return self._state is not None and self._report("CONTACT") > 0.5

    @property
    def excited(self) -> bool:
        """Whether the tip moves in contact, or did within ``settings.learning_rest``: only then it learns."""
        rest = self._m[self._places["MODE"].start + MODE.index("REST")]
        return self.in_contact and bool(rest <= self.settings.learning_rest)

    @property
    def normal_force(self) -> Estimate:
        """The normal force [N], one of the quantities of :meth:`contact_estimate`."""
        if self._state is None or self._shown is None:
            return UNKNOWN
        value, std = self._report("FORCE"), self._report("FORCE_STD")
        valid = self._trusted and self._valid() and math.isfinite(value + std)
        return Estimate(value, std, valid, self._age(self._shown))

    def contact_estimate(self) -> ContactEstimate:
        """Return what is known of the contact since the last sample."""
        state = self._shown
        if state is None:
            return ContactEstimate(0, "", 0)
        if self._state is None:
            return ContactEstimate(state.stamp, state.finger, self._seq)
        r = self._m[self._places["REPORT"]].tolist()
        age, valid = self._age(state), self._trusted and self._valid()

        def of(name: str, *, known: bool = True) -> Estimate:
            value, std = r[R[name]], r[R[name + "_STD"]]
            return Estimate(value, std, valid and known and math.isfinite(value + std), age)

        touching = r[R["CONTACT"]] > 0.5
        return ContactEstimate(
            state.stamp,
            state.finger,
            self._seq,
            in_contact=touching,
            channels=self._channels_used() if self._trusted else Channel.NONE,
            indentation=Estimate(r[R["DEPTH_NOW"]], r[R["DEPTH_STD"]], valid, age),
            normal_force=of("FORCE"),
            contact_radius=of("RADIUS", known=r[R["RADIUS_SOUND"]] > 0.5),
            pressure_exponent=of("EXPONENT", known=touching),
            friction_coefficient=of("MU"),
            limit_force=of("LIMIT_FORCE"),
            limit_torque=of("LIMIT_TORQUE"),
            limit_radius=of("LIMIT_RADIUS", known=touching),
        )

    def slip_margin(self) -> SlipMargin:
        """Return the margin for the load of the last sample, its bound, and what the present hold leads to.

        Out of contact, or without a measured tangential force, nothing is valid and the numbers are NaN. A
        torque that is not measured counts as zero.
        """
        state = self._state
        if state is None:
            return SlipMargin(0, "", 0)
        out = self._margin
        self._module.margin_of(self._m, self._tangential, self._torque, out)
        gauge, upper, reserve, when, earliest = out.tolist()
        relative, absolute = self._report("GAUGE_REL"), self._report("GAUGE_ABS")
        valid = self._valid() and self.in_contact and math.isfinite(upper)
        spread = gauge * relative
        std = math.sqrt(spread * spread + absolute * absolute)
        margin = Estimate(1.0 - gauge, std, valid, self._age(state))
        if not valid:
            margin, upper, reserve, when, earliest = UNKNOWN, NAN, NAN, NAN, NAN
        return SlipMargin(
            state.stamp,
            state.finger,
            self._seq,
            margin=margin,
            lower_bound=1.0 - upper,
            confidence=self.settings.confidence,
            force_reserve=reserve,
            time_to_slip=when,
            earliest_slip=earliest,
        )

    def least_force(self, margin: float, confidence: float | None = None) -> float:
        """Return the least normal force [N] with which the margin's lower bound stays at ``margin``.

        For the load of the last sample, at ``confidence`` (one-sided; else ``settings.confidence``), now and
        over ``settings.horizon`` of the hold in ``settings.hold``. NaN when the load or the contact is not
        known, inf when no force suffices.
        """
        if self._state is None or not self._valid():
            return NAN
        at = quantile(self.settings.confidence if confidence is None else confidence)
        return float(self._module.least_force(self._m, self._tangential, self._torque, margin, at))

    @property
    def friction(self) -> tuple[float, float, float, float]:
        """Mean and variance of ln mu: now, and before the present loading."""
        at = self._places["FRICTION"].start
        mean, variance, mean_before, variance_before = self._m[at : at + 4].tolist()
        return mean, variance, mean_before, variance_before

    def believe_friction(self, belief: tuple[float, float, float, float]) -> None:
        """Go on from another belief of friction, in the order of :attr:`friction`."""
        if self.layout.mu_learned:
            at = self._places["FRICTION"].start
            self._m[at : at + 4] = belief

    def utilisation(self) -> tuple[float, float, float]:
        """Return the friction coefficient at which the load would slip, its relative std, and the load [N].

        The load has the torque as a force at the contact radius. NaN and inf where there is no contact.
        """
        r = self._m[self._places["REPORT"]].tolist()
        gauge, radius = r[R["GAUGE"]], r[R["RADIUS"]]
        if not (gauge > 0.0 and r[R["CONTACT"]] > 0.5 and radius > 0.0):
            return NAN, math.inf, NAN
        mu = r[R["MU"]]
        friction_part = r[R["MU_STD"]] / mu if mu > 0.0 else 0.0
        known = max(r[R["GAUGE_REL"]] ** 2 - friction_part**2, 0.0)
        relative = math.sqrt(known + (r[R["GAUGE_ABS"]] / gauge) ** 2)
        torque = 0.0 if math.isnan(self._torque) else self._torque / radius
        return gauge * mu, relative, math.hypot(self._tangential, torque)

    def health(self) -> ModelHealth:
        """Return whether the model still explains the measurements, and what it fails at most.

        The verdict has hysteresis over the stamps of the samples at which it is asked for; until the next
        sample it stays the same, and asking again costs nothing.
        """
        if self._health is None:
            self._health = self._assessed()
        return self._health

    def _assessed(self) -> ModelHealth:
        if self._state is None:
            return ModelHealth(0, "", 0)
        condition = Condition.OK if self._channels_used() & 3 == 3 else Condition.DEGRADED
        if not self._valid():
            condition = Condition.STALE
        cells, channels = self._m[self._places["HEALTH"]], self._m[self._places["CHANNEL"]]
        health = health_of(self._state, self._seq, condition, cells, channels, self._watch)
        if self.lost == 0.0:
            return health
        refused = self._m[self.layout.channel_place(0, "STREAK")] > 0.0
        return replace(health, consistent=False, channel=CHANNELS[0 if refused else 1], regime=LOST)

    @property
    def lost(self) -> float:
        """For how long an estimate has contradicted its own measurement [s]; 0 while none does."""
        lost = float(self._m[self._places["MODE"].start + MODE.index("LOST")])
        return lost if lost > 0.0 else 0.0

    @property
    def restarts(self) -> int:
        """How often what is known of the contact was begun anew because it was lost."""
        return self._count("RESTARTS")

    @property
    def overflows(self) -> int:
        """How often a number of the filter was not finite any more, and everything was begun anew."""
        return self._count("OVERFLOWS")

    def _count(self, name: str) -> int:
        return int(self._m[self._places["COUNTS"].start + COUNTS.index(name)])

    def reset_health(self) -> None:
        """Forget how well the model explained what was felt so far; what is known of the contact stays."""
        self._m[self._places["HEALTH"]] = 0.0
        self._m[self._places["CHANNEL"]].reshape(len(CHANNELS), -1)[:, PER_CHANNEL.index("REJECTED")] = 0.0
        self._watch, self._health = Watch(), None

    def value(self, symbol: str) -> Estimate:
        """Return the present estimate of a parameter of the model; its std is that of the coordinate."""
        place = list(self.model.parameters).index(symbol)
        value = float(self._m[self._places["VALUES"]][place])
        if place == self.layout.mu:
            variance = self._friction_variance()
        elif place in self.layout.learned:
            j = self.layout.learned_from + self.layout.learned.index(place)
            variance = float(self.covariance[j, j])
        else:
            variance = self.model.values[symbol].std ** 2
        return Estimate(value, math.sqrt(variance), self._valid(), 0.0)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the filter's state, in the order of :attr:`covariance`.

        ``indentation`` [m], ``speed`` [m/s], states of the effects, each learned parameter (``ln K`` where
        it is learned in its logarithm), ``displacement_offset`` [m] and ``force_bias`` [N].
        """
        symbols = list(self.model.parameters)
        learned = [
            f"ln {symbols[place]}" if log else symbols[place]
            for place, log in zip(self.layout.learned, self.layout.learned_log, strict=True)
        ]
        effects = self.model.plan.states
        return ("indentation", "speed", *effects, *learned, "displacement_offset", "force_bias")

    @property
    def state(self) -> dict[str, Estimate]:
        """The filter's state by :attr:`state_names`, each with the spread that the covariance says."""
        means = self._m[self._places["Y"]].tolist()
        variances = np.diag(self.covariance).tolist()
        age = math.inf if self._shown is None else self._age(self._shown)
        valid = self._trusted and self._valid()
        estimates = (
            Estimate(mean, math.sqrt(max(variance, 0.0)), valid, age)
            for mean, variance in zip(means, variances, strict=True)
        )
        return dict(zip(self.state_names, estimates, strict=True))

    @property
    def covariance(self) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """Covariance of the filter's state (delta, speed, effect states, learned, d0, bF); a copy."""
        n = self.layout.n
        return self._m[self._places["P"]].reshape(n, n).copy()

    def _friction_variance(self) -> float:
        return float(self._m[self._places["FRICTION"]][FRICTION.index("VAR")])

    def _outside(self, state: FingertipState) -> None:
        """Pass on what effects may feel; a value that is not measured stays as it was."""
        at = self._places["EXOGENOUS"].start
        speed = 0.0 if state.slip == 0.0 else state.slip_speed  # noise is not sliding
        x, y = state.tangential_force_x, state.tangential_force_y
        given = (state.temperature, self._tangential, self._torque, speed, x, y)
        for i, value in enumerate(given):
            if math.isfinite(value):
                self._m[at + i] = value

    def _report(self, name: str) -> float:
        return float(self._m[self._report_start + R[name]])

    def _age(self, state: FingertipState) -> float:
        return (state.stamp - self._informed) / NS if self._informed == self._informed else math.inf

    def _valid(self) -> bool:
        """An estimate counts while measurements come and are not all refused."""
        if self._state is None or not self._age(self._state) <= self.settings.longest_gap:
            return False
        return self._report("SOUND") > 0.5

    def _used_any(self) -> bool:
        displacement, force, _ = self._used_places
        return bool(self._m[displacement] > 0.0 or self._m[force] > 0.0)

    def _channels_used(self) -> Channel:
        bits = 0
        for place, flag in zip(self._used_places, FLAGS, strict=True):
            if self._m[place] > 0.0:
                bits |= flag
        if self._state is not None:
            bits |= TANGENTIAL if math.isfinite(self._tangential) else 0
            bits |= TORQUE if math.isfinite(self._torque) else 0
            bits |= SLIP if math.isfinite(self._state.slip) else 0
        return CHANNEL_SETS[bits]

    def _warm(self) -> None:
        """Compile, or load from the cache, before the loop begins."""
        m = self._blank.copy()
        for dt in (-1.0, 1e-3):
            self._module.update(m, dt, 0.0, 0.0, NAN, 0.0, 0.0, 0.0)
        self._module.margin_of(m, 0.0, 0.0, np.zeros(5))
        self._module.least_force(m, 0.0, 0.0, 0.1, 1.0)


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


assert len(FLAGS) == len(CHANNELS)  # noqa: S101
