"""What a node made of a recording, finger by finger, summed up while it runs."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from vegrip.clock import NS
from vegrip.messages import (
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    Message,
    ModelHealth,
    SlipMargin,
)


@dataclass(slots=True)
class FingerSummary:
    """Counts and extremes of one finger; feed it every message in the order of the bus."""

    samples: int = 0
    commands: int = 0
    contact_time: float = 0.0  # [s]
    duration: float = 0.0  # [s]
    force_error: float = 0.0  # [N^2] sum over contact of (estimate - measurement)^2
    force_count: int = 0
    lowest_bound: float = math.inf
    highest_command: float = -math.inf
    nis_sum: float = 0.0
    nis_count: int = 0
    judged: int = 0  # health reports with a verdict
    consistent: int = 0
    rejected: int = 0
    conditions: Counter[str] = field(default_factory=Counter)
    failing: Counter[str] = field(default_factory=Counter)  # "channel, regime"
    suspects: Counter[str] = field(default_factory=Counter)
    last: ContactEstimate | None = None
    gaps: Sequence[tuple[int, int]] = ()  # [ns] between trials: no input is missing then
    _state: FingertipState | None = None

    def take(self, message: Message) -> None:
        """Count one message of this finger."""
        if isinstance(message, FingertipState):
            self._take_state(message)
        elif isinstance(message, ContactEstimate):
            self._take_contact(message)
        elif isinstance(message, SlipMargin):
            if self.last is not None and self.last.in_contact and not math.isnan(message.lower_bound):
                self.lowest_bound = min(self.lowest_bound, message.lower_bound)
        elif isinstance(message, ForceCommand):
            self.commands += 1
            self.highest_command = max(self.highest_command, message.normal_force)
        elif isinstance(message, ModelHealth):
            self._take_health(message)

    def as_dict(self) -> dict[str, Any]:
        """The summary for machines: what is not known is null."""
        last = self.last or ContactEstimate(0, "", 0)
        return {
            "samples": self.samples,
            "duration": self.duration,
            "contact_time": self.contact_time,
            "force_rms": _known(_root_mean(self.force_error, self.force_count)),
            "nis": _share(self.nis_sum, self.nis_count),
            "consistent": _share(self.consistent, self.judged),
            "rejected": self.rejected,
            "conditions": dict(self.conditions.most_common()),
            "failing": dict(self.failing.most_common()),
            "suspects": dict(self.suspects.most_common()),
            "lowest_margin_bound": _known(self.lowest_bound),
            "commands": self.commands,
            "highest_command": _known(self.highest_command),
            "pressure_exponent": _estimate(last.pressure_exponent),
            "friction_coefficient": _estimate(last.friction_coefficient),
        }

    def _take_state(self, state: FingertipState) -> None:
        if self._state is not None:
            step = (state.stamp - self._state.stamp) / NS
            self.duration += step
            recorded = not any(begin <= self._state.stamp < end for begin, end in self.gaps)
            if self.last is not None and self.last.in_contact and recorded:
                self.contact_time += step
        self.samples += 1
        self._state = state

    def _take_contact(self, contact: ContactEstimate) -> None:
        self.last = contact
        force = contact.normal_force
        if self._state is None or not contact.in_contact or math.isnan(self._state.normal_force):
            return
        error = force.value - self._state.normal_force
        self.force_error += error * error
        self.force_count += 1

    def _take_health(self, health: ModelHealth) -> None:
        if not any(begin < health.stamp < end for begin, end in self.gaps):
            self.conditions[health.condition.name.lower()] += 1
        self.rejected = health.rejected
        if math.isnan(health.nis) or self.last is None or not self.last.in_contact:
            return
        self.nis_sum += health.nis
        self.nis_count += 1
        if health.consistent:
            self.consistent += 1
        elif health.channel:  # else there is not enough to judge by
            self.failing[f"{health.channel}, {health.regime}"] += 1
            self.suspects[health.suspect or "none"] += 1
        self.judged = self.consistent + self.failing.total()


def _share(part: float, whole: int) -> float | None:
    return _known(part / whole) if whole else None


def _root_mean(squares: float, count: int) -> float:
    return math.sqrt(squares / count) if count else math.nan


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {"value": _known(estimate.value), "std": _known(estimate.std), "valid": estimate.valid}
