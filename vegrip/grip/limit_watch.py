"""Whether ``limits.max_force`` leaves what the grip needs: said where it does not, and before.

The need of a finger is the least force L that keeps its margin, over the horizon of the estimate; the thumb
also carries what the others press (:mod:`vegrip.grip.kernels.share`). The limit is *reached* while more is
needed: the margin, or the balance of the grasp, is then not kept. It is *near* while L of a load that is MORE
times the present one would be above it. What is said stays for CALM_S after its cause has gone: a need that
comes and goes is said once.
"""

import logging
import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Final

from vegrip.clock import NS
from vegrip.grip.finger import GraspFinger
from vegrip.grip.settings import Share
from vegrip.messages import LIMIT_NEAR, LIMIT_REACHED, Condition, Reason

MORE: Final = 1.5
"""Of the load: what half of the object's weight adds, or an arm that speeds up by 5 m/s^2."""
LOOK_NS: Final = NS // 5  # [ns] between two looks
CALM_S: Final = 2.0  # [s]
RANKS: Final = ("", LIMIT_NEAR, LIMIT_REACHED)


@dataclass(frozen=True, slots=True)
class Need:
    """What a finger is to press with [N]; NaN where that is not known, infinite where no force suffices."""

    now: float = math.nan
    under_more: float = math.nan  # load


@dataclass(slots=True)
class _Standing:
    """Of one finger."""

    need: Need
    state: str = ""
    seen: int = 0  # [ns] when there was cause for it last


class LimitWatch:
    """Looks at all fingers of a grasp now and then; ``share`` says what each presses with for their needs."""

    def __init__(self, share: Share) -> None:
        self.is_letting_go = False
        """Whether the limit is being lowered on purpose: nothing is said then."""
        self._share = share
        self._of: dict[str, _Standing] = {}
        self._looked: int | None = None  # [ns]
        self._reported: dict[str, str] = {}

    def state(self, finger: str) -> str:
        """Return "", LIMIT_NEAR or LIMIT_REACHED."""
        return self._of[finger].state if finger in self._of else ""

    def look(self, fingers: Mapping[str, GraspFinger], most: float, now: int) -> None:
        """Look at ``fingers``, which are given ``most`` [N] at most, when that is due at ``now`` [ns]."""
        if self._looked is not None and 0 <= now - self._looked < LOOK_NS:
            return
        self._looked = now
        needs = {name: _need(finger) for name, finger in fingers.items() if finger.started}
        shares = self._share(_known({name: one.now for name, one in needs.items()}))
        more = self._share(_known({name: one.under_more for name, one in needs.items()}))
        for name, own in needs.items():
            need = Need(shares.get(name, own.now), more.get(name, own.under_more))
            state = LIMIT_NEAR if need.under_more > most else ""
            if _is_limited(fingers[name]):
                state = LIMIT_REACHED
            self._judge(name, need, "" if self.is_letting_go else state, now)

    def log_changes(self, logger: logging.Logger, most: float) -> None:
        """Log what has changed; ``most`` [N] is the limit."""
        for name, one in self._of.items():
            if one.state == self._reported.get(name, ""):
                continue
            self._reported[name] = one.state
            if one.state:
                does = "stops" if one.state == LIMIT_REACHED else "may stop"
                logger.warning("%s: limits.max_force (%g N) %s the grip: %s", name, most, does, _why(one))
            else:
                logger.info("%s: limits.max_force (%g N) suffices again", name, most)

    def _judge(self, name: str, need: Need, state: str, now: int) -> None:
        one = self._of.setdefault(name, _Standing(need))
        one.need = need
        is_less = RANKS.index(state) < RANKS.index(one.state)
        if is_less and 0 <= now - one.seen < CALM_S * NS and not self.is_letting_go:
            return
        one.state, one.seen = state, now


def against_thumb(needs: Mapping[str, float], thumb: str) -> dict[str, float]:
    """Return what each finger presses with [N] where the ``thumb`` carries the others."""
    others = sum(need for name, need in needs.items() if name != thumb)
    total = max(needs.get(thumb, 0.0), others)
    if thumb not in needs or not 0.0 < others < math.inf:
        return dict(needs)
    return {name: total if name == thumb else need * total / others for name, need in needs.items()}


def _known(needs: Mapping[str, float]) -> dict[str, float]:
    return {name: need for name, need in needs.items() if not math.isnan(need)}


def _need(finger: GraspFinger) -> Need:
    memory = finger.memory
    if finger.condition > Condition.DEGRADED or not memory["NEED_TRUSTED"]:
        return Need()
    least = memory["DEMAND_LEAST"]
    return Need(least, least * _growth(finger) if memory["NEED_IN_CONTACT"] and least > 0.0 else least)


def _growth(finger: GraspFinger) -> float:
    """Return by what the need grows with the load: by more than the load where friction falls with it."""
    memory = finger.memory
    load, torque = memory["DEMAND_LOAD"], memory["DEMAND_TORQUE"]
    torque = 0.0 if math.isnan(torque) else torque
    asked = memory["ASKED_MARGIN"], NormalDist().cdf(memory["ASKED_QUANTILE"])
    now = finger.estimator.least_force(*asked, (load, torque))
    more = finger.estimator.least_force(*asked, (MORE * load, MORE * torque))
    return more / now if now > 0.0 else MORE


def _is_limited(finger: GraspFinger) -> bool:
    return Reason.MAX_LIMIT in (finger.command().reason, finger.standing_command().reason)


def _why(one: _Standing) -> str:
    if one.state == LIMIT_REACHED:
        return f"{one.need.now:.3g} N are needed" if one.need.now < math.inf else "no force suffices"
    more = f"{one.need.under_more:.3g} N" if one.need.under_more < math.inf else "more than any force"
    return f"{one.need.now:.3g} N are needed now, and {more} for half as much load again"
