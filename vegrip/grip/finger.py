"""One finger of the node: watchdog, estimator, controller, and what is reported of them."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

from vegrip.clock import NS
from vegrip.estimator.estimator import SLIPS, quantile
from vegrip.estimator.learning import Learned
from vegrip.estimator.settings import SensorNoise
from vegrip.grip.bumpless_transfer import BumplessTransfer
from vegrip.grip.confirmed_load import CONFIRM_SIZE, confirm_load
from vegrip.grip.drive_lag import follow_drive
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger_controller import FingerController
from vegrip.grip.load_lead import lead_load
from vegrip.grip.policies.demand import Demand
from vegrip.grip.recent_states import RecentStates
from vegrip.grip.safety.watchdog import InputWatchdog
from vegrip.grip.settings import ControlSettings, apply_policy
from vegrip.messages import (
    Condition,
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    LearnedParameter,
    Message,
    ModelHealth,
    SlipMargin,
)
from vegrip.types import NamedNumbers, Numbers

Wanted = tuple[float, float]
"""Margin to keep [-], and the one-sided confidence to keep it with."""

UNTRUSTED_DEMAND = Demand()
"""The demand of a finger whose input is not believed."""

LONGEST_STEP_S = 0.1
"""A longer pause between two states counts as so much."""
RECENT_STATES = 2000
"""States kept for a successor: four seconds at 500 Hz, some relaxation times and mostly the first touch."""

USUAL_NOISE = SensorNoise()
"""Of the sensors of a finger whose estimator does not tell it."""

LOAD_CHANNELS = frozenset({"tangential_force_x", "tangential_force_y", "torque_z"})
"""Channels that make up the load. One that was lost is not zero: without it the margin is not believed."""


class GraspFinger:
    """Everything the node keeps of one finger.

    Args:
        name: of the finger.
        estimator: of its contact.
        controller: of its force.
        watchdog: over its input.
        phase: share of a report period by which its reports keep their distance from those of the first
            finger; the reports of all fingers at once would delay the commands behind them.

    """

    def __init__(
        self,
        name: str,
        estimator: Estimator,
        controller: FingerController,
        watchdog: InputWatchdog,
        phase: float = 0.0,
    ) -> None:
        self.name = name
        self.estimator = estimator
        self.controller = controller
        self.watchdog = watchdog
        self._seen = False  # the estimator has had a state
        self._transfer = BumplessTransfer()
        self._margin: SlipMargin | None = None
        self._used = 0  # [ns] arrival of the last state that was believed
        self._reported = self._healthy = self._learned_at = -math.inf  # [ns] when last told
        self._reports = self._healths = self._learned_count = 0  # how often
        self._told: Condition | None = None  # the condition in the last ModelHealth
        self._phase = phase
        self.lead_in: tuple[Numbers, int] | None = None
        """Where the load is led by the lag of the drive, and the finger's place in it."""
        self._confirmed = [math.nan] * CONFIRM_SIZE  # load that counts
        self._led = 0  # [ns] stamp of the last state whose load was led
        self.past = RecentStates(RECENT_STATES)
        """What was believed of late, for an estimator that takes over."""

    def sense(self, state: FingertipState, now: int, wanted: Wanted, *, slides: bool = False) -> bool:
        """Take in one state that arrived at ``now`` [ns] and ask the controller what it needs.

        A finger slips where its flag says so, and where it ``slides`` by something else.

        Returns whether the state is believed. The margin itself, which no command waits for, is worked out
        when it is reported.
        """
        demand = UNTRUSTED_DEMAND
        believed = self.watchdog.accept(state, now)
        if believed:
            self.estimator.assimilate(state)
            self.past.append(state)
            first, self._seen = not self._seen, True
            if self._margin is None:
                self._margin = self.estimator.slip_margin()
            self._used = now
            demand = self._demand(state, self._margin, wanted, slides)
            if not self.controller.started:
                self.controller.start(self._present_force(state), now)
            if first:
                arm = self.estimator.contact_estimate().contact_radius.value
                self._transfer.begin(self.controller.required_force, demand, arm, now)
        if self.controller.started:
            demand = self._bound_takeover(demand, now)
            demand = self._hold_doubtful(demand) if self.watchdog.doubtful else demand
            self.controller.update(self.watchdog.condition, demand, now)
        return believed

    def watch(self, now: int) -> None:
        """Look for silence; under a fault the controller rides it out by the clock."""
        condition = self.watchdog.tick(now)
        if condition > Condition.DEGRADED and self.controller.due(now):
            self.controller.update(condition, UNTRUSTED_DEMAND, now)

    def restart(self) -> None:
        """Forget input and contact but keep the command: the node is back from a fault of its own."""
        self.estimator.reset()
        self.watchdog.reset()
        self._seen, self._margin = False, None
        self._confirmed = [math.nan] * CONFIRM_SIZE

    def replace_estimator(self, estimator: Estimator) -> None:
        """Go on with ``estimator``, which knows the past but for the very last samples."""
        known = estimator.contact_estimate().stamp
        for state in self.past.after(known):
            estimator.assimilate(state)
        self.estimator = estimator
        self._margin = None

    def apply(self, settings: ControlSettings) -> None:
        """Go on with other settings; what has been learned and what is held stay."""
        self.watchdog.settings = settings.watchdog
        self.controller.limits = settings.limits
        self.controller.fail_safe.settings = settings.fail_safe
        apply_policy(self.controller.policy, settings)

    def write_to(self, memory: NamedNumbers, confidence: float, periods: tuple[float, float]) -> None:
        """Lend everything to the compiled finger step; only with a margin grip and a ContactEstimator.

        Args:
            memory: where it goes.
            confidence: with which the margin is kept.
            periods: of reports and of ModelHealth [s].

        """
        for part in (self.estimator, self.watchdog, self.controller, self.controller.fail_safe):
            part.write_to(memory)  # type: ignore[union-attr]
        self.controller.policy.write_to(memory)  # type: ignore[attr-defined]
        self._transfer.write_to(memory)
        memory["RULE_QUANTILE"] = quantile(confidence)
        memory["TURN_SEEN"], memory["TURN_USED"] = self._seen, self._used
        memory["TURN_LED"] = self._led
        memory.section("CONFIRMED")[:] = self._confirmed
        self.write_told(memory, periods)

    def write_told(self, memory: NamedNumbers, periods: tuple[float, float]) -> None:
        """Hand over what was told last, and when it is told again: ``periods`` of reports and health [s]."""
        bound = math.nan if self._margin is None else self._margin.lower_bound
        memory["TURN_HAS_MARGIN"], memory["TAKEN_BOUND"] = self._margin is not None, bound
        memory["TURN_TOLD"] = -1 if self._told is None else self._told
        memory["TURN_REPORTS"] = self._reports
        memory["SETUP_REPORT_PERIOD"] = math.ceil(periods[0] * NS)
        contact, health = self._reported + periods[0] * NS, self._healthy + periods[1] * NS
        memory["TURN_CONTACT_DUE"], memory["TURN_HEALTH_DUE"] = _whole(contact), _whole(health)
        memory["TURN_REPORT_DUE"] = _whole(min(contact, health))

    def read_from(self, memory: NamedNumbers, taken: int, last: FingertipState) -> None:
        """Take back what the compiled finger step has made of it.

        Args:
            memory: where it lies.
            taken: how many states were believed since :meth:`write_to`; :attr:`past` has them.
            last: the last state, believed or not.

        """
        self.estimator.read_rewind(self.past, taken)  # type: ignore[attr-defined]
        self.read_contact(memory, next(iter(self.past.last(1)), None) if taken else None)
        self.watchdog.read_from(memory, last)
        self.controller.read_from(memory)
        self.controller.fail_safe.read_from(memory)
        self.controller.policy.read_from(memory)  # type: ignore[attr-defined]
        self._transfer.read_from(memory)
        self._led = int(memory["TURN_LED"])
        self._confirmed = memory.section("CONFIRMED").tolist()

    def read_contact(self, memory: NamedNumbers, believed: FingertipState | None) -> None:
        """Take back no more than what is reported: the contact, and whether the input is believed.

        ``believed`` is the last state that was, None where none was since :meth:`write_to`.
        """
        if believed is not None:
            self.estimator.read_from(memory, believed)  # type: ignore[attr-defined]
        self.watchdog.condition = Condition(memory["INPUT_CONDITION"])
        self._seen, self._used = bool(memory["TURN_SEEN"]), memory["TURN_USED"]
        if self._margin is None and memory["TURN_HAS_MARGIN"]:
            self._margin = SlipMargin(0, self.name, 0, lower_bound=memory["TAKEN_BOUND"])
        self.read_told(memory)

    def read_told(self, memory: NamedNumbers) -> None:
        """Take back what the compiled step has told of contact and margin."""
        if memory["TURN_REPORTS"] == self._reports:
            return
        self._reports, self._reported = memory["TURN_REPORTS"], memory["TURN_REPORTED"]
        self._margin = SlipMargin(0, self.name, 0, lower_bound=memory["TAKEN_BOUND"])

    def command(self, share: float, now: int) -> ForceCommand:
        """Return the command for this finger's share of the grasp [N]."""
        return self.controller.command(share, now)

    def health_due(self, now: int, health_period: float) -> bool:
        """Whether it is time to look at the health of the model."""
        return _due(self._healthy, now, health_period)

    def contact(self, now: int) -> ContactEstimate:
        """Return what is known of the contact at ``now`` [ns]; not valid while the input is not trusted."""
        contact = replace(self.estimator.contact_estimate(), finger=self.name, seq=self._reports)
        return contact if self._fresh else _untrusted_contact(contact, self._age(now))

    def margin(self, now: int) -> SlipMargin:
        """Return the slip margin at ``now`` [ns]; not valid while the input is not trusted."""
        return self._judged_margin(self.estimator.slip_margin(), now)

    def health(self, now: int) -> ModelHealth:
        """Return whether the model explains what is measured, and the condition of the input."""
        condition = self.watchdog.condition
        health = self.estimator.health()
        return replace(health, stamp=now, finger=self.name, seq=self._healths, condition=condition)

    def reports(self, now: int, report_period: float, health_period: float) -> Iterator[Message]:
        """Yield what is due to be told: contact, margin, and less often the health of the model.

        A change of the condition is told at once.
        """
        if self._seen and self._margin is not None and _due(self._reported, now, report_period):
            self._reported = self._staggered(self._reported, now, report_period)
            self._margin = self.estimator.slip_margin()
            contact, margin = self.contact(now), self._judged_margin(self._margin, now)
            self._reports += 1
            yield contact
            yield margin
        condition = self.watchdog.condition
        due = self.health_due(now, health_period)
        if due or condition is not self._told:
            self._told = condition
            self._healthy = self._staggered(self._healthy, now, health_period) if due else self._healthy
            yield self.health(now)
            self._healths += 1

    def learned_messages(self, learned: Mapping[str, Learned], now: int, period: float) -> Iterator[Message]:
        """Yield what is learned, one message for each parameter, when that is due."""
        if not _due(self._learned_at, now, period):
            return
        self._learned_at = self._staggered(self._learned_at, now, period)
        for symbol, one in learned.items():
            filtered = Estimate(one.filtered, one.raw.std, one.valid, one.raw.age)
            yield LearnedParameter(
                now, self.name, self._learned_count, symbol, one.raw, filtered, one.excited
            )
            self._learned_count += 1

    def _staggered(self, last: float, now: int, period: float) -> float:
        first = last == -math.inf
        return now - self._phase * period * NS if first else now

    def _judged_margin(self, margin: SlipMargin, now: int) -> SlipMargin:
        margin = replace(margin, finger=self.name, seq=self._reports)
        return margin if self._fresh else _untrusted_margin(margin, self._age(now))

    @property
    def _fresh(self) -> bool:
        return self.watchdog.condition <= Condition.DEGRADED

    def _age(self, now: int) -> float:
        return max(0.0, (now - self._used) / NS) if self._seen else math.inf

    def _present_force(self, state: FingertipState) -> float:
        if not math.isnan(state.normal_force):
            return state.normal_force
        return self.estimator.normal_force.value

    def _bound_takeover(self, demand: Demand, now: int) -> Demand:
        """Return ``demand`` with no more force than a contact that was met in its middle shows to suffice."""
        fail_safe = self.controller.fail_safe.settings
        least = self._transfer.bounded(demand.least_force, demand, now, fail_safe)
        return demand if not least < demand.least_force else replace(demand, least_force=least)

    def _hold_doubtful(self, demand: Demand) -> Demand:
        """Return ``demand`` with no less force than is held, and no belief that the finger is in the air."""
        return replace(demand, least_force=max(self.controller.held, demand.least_force), in_contact=True)

    def _demand(self, state: FingertipState, margin: SlipMargin, wanted: Wanted, slides: bool) -> Demand:
        x, y = state.tangential_force_x, state.tangential_force_y
        load = math.sqrt(x * x + y * y)  # not math.hypot: Python's rounds otherwise than C's
        torque, slipping = abs(state.torque_z), slides or state.slip >= SLIPS
        if not self.estimator.in_contact:
            trusted = self.estimator.normal_force.valid
            return Demand(0.0, load, torque, in_contact=False, slipping=slipping, trusted=trusted)
        asked = self.controller.policy.uses_least_force and not self.watchdog.lost & LOAD_CHANNELS
        least = self._least_force(state, wanted) if asked else math.nan
        return Demand(
            least_force=least,
            tangential_force=load,
            torque=torque,
            margin_bound=margin.lower_bound,
            in_contact=True,
            slipping=slipping,
            trusted=not math.isnan(least),  # infinite: no force suffices, so the largest is best
        )

    def _least_force(self, state: FingertipState, wanted: Wanted) -> float:
        x, y, torque = state.tangential_force_x, state.tangential_force_y, state.torque_z
        noise = getattr(self.estimator, "noise", USUAL_NOISE)
        x, y, torque = confirm_load(self._confirmed, 0, x, y, torque, noise.tangential_force, noise.torque_z)
        if self.lead_in is None:
            return self.estimator.least_force(*wanted, (math.sqrt(x * x + y * y), torque))
        dt = min(max((state.stamp - self._led) / NS, 0.0), LONGEST_STEP_S)
        self._led = state.stamp
        is_following = not (self.controller.fail_safe.active or self.watchdog.doubtful)
        command = self.controller.held if is_following else math.nan
        follow_drive(*self.lead_in, dt, command, state.normal_force)
        return self.estimator.least_force(*wanted, lead_load(*self.lead_in, dt, x, y, torque))


def _whole(due: float) -> int:
    """Return a time [ns] as the compiled step has it; 0: at once."""
    return math.ceil(due) if due > 0.0 else 0


def _due(last: float, now: int, period: float) -> bool:
    return now - last >= period * NS or now < last  # a clock that jumped back must not silence the reports


def _untrusted_contact(contact: ContactEstimate, age: float) -> ContactEstimate:
    return replace(
        contact,
        indentation=_untrusted(contact.indentation, age),
        normal_force=_untrusted(contact.normal_force, age),
        contact_radius=_untrusted(contact.contact_radius, age),
        pressure_exponent=_untrusted(contact.pressure_exponent, age),
        friction_coefficient=_untrusted(contact.friction_coefficient, age),
        limit_force=_untrusted(contact.limit_force, age),
        limit_torque=_untrusted(contact.limit_torque, age),
        limit_radius=_untrusted(contact.limit_radius, age),
    )


def _untrusted_margin(margin: SlipMargin, age: float) -> SlipMargin:
    unknown = math.nan
    return replace(
        margin,
        margin=_untrusted(margin.margin, age),
        lower_bound=unknown,
        force_reserve=unknown,
        time_to_slip=unknown,
        earliest_slip=unknown,
    )


def _untrusted(estimate: Estimate, age: float) -> Estimate:
    """Nothing is known of the present: any spread is possible."""
    return Estimate(estimate.value, math.inf, valid=False, age=age)
