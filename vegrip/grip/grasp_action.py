"""Grasp and release: a goal, whether it is reached, and why not. Pure.

The grip itself stays with the controller. To close, its least force is raised to that of the goal; to
release, its largest is let down to zero. The grasp is made when enough fingers touch, press as they were
asked to, and the lower bound of each one's slip margin has been at the goal for a while. Where no margin is
known (no tangential force is measured) force alone decides, and the reason says so.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.grip.finger import GraspFinger
from vegrip.grip.safety import MAX_FORCE_N, LimitSettings
from vegrip.messages import Condition, GraspPhase, GraspStatus

LOOK_PERIOD: Final = NS // 50  # [ns] between two looks at the fingers
STATUS_PERIOD: Final = NS  # [ns] between two messages of one phase
SETTLED: Final = NS // 5  # [ns] for which what ends a phase must hold
PRESSED: Final = 0.8  # of the force that was asked for
NOT_YET: Final = -(1 << 62)  # [ns]
RELEASED_FORCE: Final = 0.1  # [N] that an open finger may feel
TRUSTED: Final = (Condition.OK, Condition.DEGRADED)


@dataclass(frozen=True)
class GraspGoal:
    """What is asked for."""

    force: float = parameter(2.0, unit="N", low=0.0, high=MAX_FORCE_N, doc="every finger closes with so much")
    max_force: float = parameter(
        MAX_FORCE_N, unit="N", low=0.0, high=MAX_FORCE_N, doc="most for this object; never above the limits"
    )
    margin: float = parameter(
        0.0, unit="1", low=-1.0, high=1.0, doc="lower bound of the slip margin from which it counts as held"
    )
    timeout: float = parameter(5.0, unit="s", low=0.1, high=600.0, doc="then the result is what there is")


@dataclass(frozen=True)
class ReleaseGoal:
    """How to release."""

    rate: float = parameter(10.0, unit="N/s", low=0.1, high=1e3, doc="by which the force falls")
    timeout: float = parameter(5.0, unit="s", low=0.1, high=600.0, doc="then the result is what there is")


@dataclass(frozen=True)
class _Look:
    """All fingers at one time."""

    touching: tuple[str, ...]
    faults: tuple[str, ...]  # "index stale"
    force: float  # [N] the largest that is felt, NaN where no finger is seen
    soft: tuple[str, ...]  # touching, and pressing less than was asked for
    bounds: Mapping[str, float]  # [-] of the margins of those that touch, where known
    is_limited: bool  # a command is at the largest force

    @property
    def margin(self) -> float:
        """The least bound, NaN where none is known."""
        return min(self.bounds.values(), default=math.nan)


class GraspAction:
    """The grasp of one hand."""

    def __init__(self, node: str, fingers: Sequence[str], thumb: str = "") -> None:
        self.phase = GraspPhase.NONE
        self.reason = ""
        self._node, self._fewest = node, min(2, len(fingers))
        self._thumb = thumb if thumb in fingers else ""
        self._goal: GraspGoal | ReleaseGoal = GraspGoal()
        self._began = self._since = self._look_due = self._sent = NOT_YET  # [ns]
        self._seq = 0
        self._most = self._limit = math.inf  # [N] of this goal; and that of the hand, too
        self._last: _Look | None = None

    def grasp(self, goal: GraspGoal) -> None:
        self._begin(GraspPhase.CLOSING, goal)
        self._most = goal.max_force

    def release(self, goal: ReleaseGoal, fingers: Mapping[str, GraspFinger]) -> None:
        self._begin(GraspPhase.RELEASING, goal)
        self._most = max((finger.held for finger in fingers.values() if finger.held >= 0.0), default=0.0)

    def limits(self, stated: LimitSettings) -> LimitSettings:
        """Return the limits that the grip keeps now; those that were ``stated`` always hold, too."""
        most = self._limit = min(stated.max_force, self._most)
        least = stated.min_force
        if self.phase is GraspPhase.CLOSING and isinstance(self._goal, GraspGoal):
            least = max(least, self._goal.force)
        return replace(stated, min_force=min(least, most), max_force=most)

    def look(self, fingers: Mapping[str, GraspFinger], now: int) -> bool:
        """Look at the fingers, when that is due; whether the limits may be others now."""
        if self.phase is GraspPhase.NONE or now < self._look_due:
            return False
        if self._began == NOT_YET:
            self._began = self._since = now
        self._look_due = now + LOOK_PERIOD
        look = self._last = _look(fingers, now, self._limit)
        if isinstance(self._goal, ReleaseGoal):
            self._most = max(self._most - self._goal.rate * LOOK_PERIOD / NS, 0.0)
        phase, reason = self._verdict(look)
        if phase is self.phase:
            self._since = now
            self.reason = reason
        elif now - self._since >= SETTLED:
            self.phase, self.reason, self._since, self._sent = phase, reason, now, NOT_YET
        return True

    def status(self, now: int) -> GraspStatus | None:
        """Return the message that is due, None where none is."""
        if self.phase is GraspPhase.NONE or now - self._sent < STATUS_PERIOD:
            return None
        self._sent, self._seq = now, self._seq + 1
        return self.result(now)

    def result(self, now: int) -> GraspStatus:
        """Return how it stands."""
        look = self._last
        force, margin = (math.nan, math.nan) if look is None else (look.force, look.margin)
        return GraspStatus(now, self._node, self._seq, self.phase, self.reason[:64], force, margin)

    def _begin(self, phase: GraspPhase, goal: GraspGoal | ReleaseGoal) -> None:
        self.phase, self.reason, self._goal, self._last = phase, "", goal, None
        self._began = self._look_due = self._sent = NOT_YET

    def _is_late(self, now: int) -> bool:
        return now - self._began >= self._goal.timeout * NS

    def _verdict(self, look: _Look) -> tuple[GraspPhase, str]:
        if self.phase in (GraspPhase.RELEASING, GraspPhase.RELEASED):
            return self._verdict_of_release(look)
        missing = self._missing(look)
        is_closing = self.phase is GraspPhase.CLOSING
        is_late = is_closing and self._is_late(self._look_due)
        if look.faults:
            reason = f"not judged: {', '.join(look.faults)}"
            return (GraspPhase.WEAK if is_late else self.phase), reason
        if missing:
            if is_closing:
                return (GraspPhase.MISSED if is_late else self.phase), missing
            return GraspPhase.MISSED, self.reason if self.phase is GraspPhase.MISSED else f"lost: {missing}"
        return self._verdict_of_force(look, is_closing=is_closing, is_late=is_late)

    def _verdict_of_force(self, look: _Look, *, is_closing: bool, is_late: bool) -> tuple[GraspPhase, str]:
        goal = self._goal
        assert isinstance(goal, GraspGoal)  # noqa: S101 (of a phase of grasping)
        low = [name for name, bound in look.bounds.items() if not bound >= goal.margin]
        if low:
            reason = f"margin of {low[0]} above {look.bounds[low[0]]:.2f}, not {goal.margin:g}"
            ends = look.is_limited or is_late or not is_closing
            return (GraspPhase.WEAK if ends else self.phase), reason + (
                ", at the limit" if look.is_limited else ""
            )
        if look.soft and self.phase is not GraspPhase.HELD:
            reason = f"{look.soft[0]} presses less than it is asked to"
            return (GraspPhase.WEAK if is_late or not is_closing else self.phase), reason
        return GraspPhase.HELD, "" if look.bounds else "by force alone: no margin is known"

    def _verdict_of_release(self, look: _Look) -> tuple[GraspPhase, str]:
        if self._most > 0.0:
            return GraspPhase.RELEASING, ""
        if math.isnan(look.force):
            return GraspPhase.RELEASING, f"not judged: {', '.join(look.faults)}"
        if look.force > RELEASED_FORCE and not self._is_late(self._look_due):
            return GraspPhase.RELEASING, f"{look.force:.1f} N is still felt"
        return GraspPhase.RELEASED, f"{look.force:.1f} N is felt" if look.force > RELEASED_FORCE else ""

    def _missing(self, look: _Look) -> str:
        """Return what keeps this from being a grasp: two fingers, the thumb among them, touch."""
        if self._thumb and self._thumb not in look.touching:
            return f"{self._thumb} touches nothing"
        return "" if len(look.touching) >= self._fewest else f"{len(look.touching)} fingers touch"


def _look(fingers: Mapping[str, GraspFinger], now: int, most: float) -> _Look:
    touching, faults, soft, bounds = [], [], [], {}
    largest, is_limited = 0.0, False
    for name, finger in fingers.items():
        if finger.condition not in TRUSTED:
            faults.append(f"{name} {finger.condition.name.lower().replace('_', ' ')}")
            continue
        force, _ = finger.numbers.felt()
        largest = max(largest, force) if force == force else largest  # noqa: PLR0124 (NaN)
        if not finger.reports.contact(now).in_contact:
            continue
        touching.append(name)
        is_limited = is_limited or finger.held >= most
        if force < PRESSED * finger.held:
            soft.append(name)
        if not math.isnan(bound := finger.reports.margin(now).lower_bound):
            bounds[name] = bound
    largest = largest if len(faults) < len(fingers) else math.nan
    return _Look(tuple(touching), tuple(faults), largest, tuple(soft), bounds, is_limited)
