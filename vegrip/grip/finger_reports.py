"""What a finger reports, and when: contact, slip margin, health of the model, learned parameters."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from typing import Any, Final, TypeVar

from vegrip import messages
from vegrip.clock import NS
from vegrip.estimator.learning import Learned
from vegrip.grip.finger_step import FingerStep
from vegrip.grip.settings import ControlSettings

Reported = TypeVar("Reported", messages.ContactEstimate, messages.SlipMargin)

CONDITIONS: Final = tuple(messages.Condition)
NO_MARGIN: Final = dict.fromkeys(("lower_bound", "force_reserve", "time_to_slip", "earliest_slip"), math.nan)


class FingerReports:
    """The reports of one finger.

    Args:
        step: its numbers.
        settings: periods of its reports.
        phase: share of a report period by which its reports keep their distance from those of the first
            finger; the reports of all fingers at once would delay the commands behind them.

    """

    def __init__(self, step: FingerStep, settings: ControlSettings, phase: float) -> None:
        self._step, self._settings, self._phase = step, settings, phase
        self._healthy = self._learned_at = -math.inf  # [ns] when last reported
        self._healths = self._learned_count = 0  # how often

    def apply(self, settings: ControlSettings) -> None:
        """Go on with the periods of ``settings``."""
        self._settings = settings
        self._set_due()

    @property
    def condition(self) -> messages.Condition:
        found: messages.Condition = CONDITIONS[self._step.memory["INPUT_CONDITION"]]
        return found

    def contact(self, now: int) -> messages.ContactEstimate:
        """Return what is known of the contact at ``now`` [ns]; not valid while the input is not trusted."""
        contact = replace(
            self._step.estimator.contact_estimate(),
            finger=self._step.name,
            seq=self._step.memory["TURN_REPORTS"],
        )
        return contact if self._is_fresh else _untrusted(contact, self._age(now))

    def margin(self, now: int) -> messages.SlipMargin:
        """Return the slip margin at ``now`` [ns]; not valid while the input is not trusted."""
        return self._judged_margin(self._step.estimator.slip_margin(), now)

    def health(self, now: int) -> messages.ModelHealth:
        health = self._step.estimator.health()
        return replace(health, stamp=now, finger=self._step.name, seq=self._healths, condition=self.condition)

    def due(self, now: int) -> Iterator[messages.Message]:
        """Yield what is due: contact, margin, and less often the health of the model.

        A change of the condition is reported at once.
        """
        memory, periods = self._step.memory, self._settings
        if memory["TURN_SEEN"] and memory["TURN_HAS_MARGIN"] and self._is_contact_due(now):
            first = memory["TURN_CONTACT_DUE"] == 0
            at = now - self._phase * periods.report_period * NS if first else now
            memory["TURN_REPORTED"] = int(at)
            margin = self._step.estimator.slip_margin()
            memory["TAKEN_BOUND"] = margin.lower_bound
            contact, margin = self.contact(now), self._judged_margin(margin, now)
            memory["TURN_REPORTS"] += 1
            memory["TURN_CONTACT_DUE"] = max(math.ceil(at + periods.report_period * NS), 1)
            self._set_due()
            yield contact
            yield margin
        is_due = self.health_due(now)
        if is_due or self.condition != memory["TURN_REPORTED_CONDITION"]:
            memory["TURN_REPORTED_CONDITION"] = self.condition
            if is_due:
                first = self._healthy == -math.inf
                self._healthy = now - self._phase * periods.health_period * NS if first else now
            self._set_due()
            yield self.health(now)
            self._healths += 1

    def health_due(self, now: int) -> bool:
        return _due(self._healthy, now, self._settings.health_period)

    def learned(self, learned: Mapping[str, Learned], now: int) -> Iterator[messages.Message]:
        """Yield what is learned, one message for each parameter, when that is due."""
        period = self._settings.learned_period
        if not _due(self._learned_at, now, period):
            return
        first = self._learned_at == -math.inf
        self._learned_at = now - self._phase * period * NS if first else now
        for symbol, one in learned.items():
            filtered = messages.Estimate(one.filtered, one.raw.std, one.valid, one.raw.age)
            yield messages.LearnedParameter(
                now, self._step.name, self._learned_count, symbol, one.raw, filtered, one.excited
            )
            self._learned_count += 1

    def are_due(self, now: int) -> bool:
        """Return whether :meth:`due` has something to report, or half of the history is to be fetched."""
        whole, layout = self._step.wholes, self._step.layout.wholes
        is_changed = whole[layout["INPUT_CONDITION"]] != whole[layout["TURN_REPORTED_CONDITION"]]
        return bool(now >= whole[layout["TURN_REPORT_DUE"]] or is_changed or self._step.is_half_full())

    def _is_contact_due(self, now: int) -> bool:
        # a clock that jumped back must not silence the reports
        return bool(now >= self._step.memory["TURN_CONTACT_DUE"] or now < self._step.memory["TURN_REPORTED"])

    def _set_due(self) -> None:
        memory = self._step.memory
        period = math.ceil(self._settings.report_period * NS)
        if period != memory["SETUP_REPORT_PERIOD"] and memory["TURN_CONTACT_DUE"]:
            memory["TURN_CONTACT_DUE"] = max(memory["TURN_REPORTED"] + period, 1)
        memory["SETUP_REPORT_PERIOD"] = period
        health = self._healthy + self._settings.health_period * NS
        memory["TURN_HEALTH_DUE"] = math.ceil(health) if health > 0.0 else 0
        memory["TURN_REPORT_DUE"] = min(memory["TURN_CONTACT_DUE"], memory["TURN_HEALTH_DUE"])

    def _judged_margin(self, margin: messages.SlipMargin, now: int) -> messages.SlipMargin:
        margin = replace(margin, finger=self._step.name, seq=self._step.memory["TURN_REPORTS"])
        return margin if self._is_fresh else _untrusted(margin, self._age(now), **NO_MARGIN)

    @property
    def _is_fresh(self) -> bool:
        return self.condition <= messages.Condition.DEGRADED

    def _age(self, now: int) -> float:
        memory = self._step.memory
        return max(0.0, (now - memory["TURN_USED"]) / NS) if memory["TURN_SEEN"] else math.inf


def _due(last: float, now: int, period: float) -> bool:
    return now - last >= period * NS or now < last  # a clock that jumped back must not silence the reports


def _untrusted(message: Reported, age: float, **unknown: float) -> Reported:
    """Return ``message`` with nothing known of the present: any spread is possible."""
    values = {field.name: getattr(message, field.name) for field in fields(message)}
    found = {name: one for name, one in values.items() if isinstance(one, messages.Estimate)}
    vague = {name: replace(one, std=math.inf, valid=False, age=age) for name, one in found.items()}
    values_now: Any = {**vague, **unknown}
    return replace(message, **values_now)
