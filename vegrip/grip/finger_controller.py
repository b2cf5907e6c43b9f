"""The control of one finger: policy, fail-safe, limits, and the command that comes out."""

import math

from vegrip.clock import NS
from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.policy import GripPolicy
from vegrip.grip.safety.fail_safe import FailSafe
from vegrip.grip.safety.limits import LimitSettings, clamp_force, limit_force
from vegrip.messages import Condition, ForceCommand, Reason
from vegrip.types import NamedNumbers

RENEWAL = 0.25
"""Part of its lifetime after which a command is renewed: three of them may get lost."""


class FingerController:
    """From the demand of one finger to its commands.

    Two steps, because the grasp has its say between them::

        controller.want(condition, demand, now)  # .need [N]: what this finger needs on its own
        controller.command(share, now)           # share [N]: its need, or more for the grasp's balance

    The first command equals the force that is there (no bump at activation); before :meth:`start` there is
    no command at all.
    """

    def __init__(self, finger: str, policy: GripPolicy, fail_safe: FailSafe, limits: LimitSettings) -> None:
        self.finger = finger
        self.policy = policy
        self.fail_safe = fail_safe
        self.limits = limits
        self.required_force = 0.0  # [N]
        self.reason = Reason.HOLD
        self._held = math.nan  # [N] commanded last
        self._commanded = 0  # [ns] and when
        self._asked = 0  # [ns] when the need was last asked
        self._seq = 0

    @property
    def started(self) -> bool:
        """Whether there is a command to hold."""
        return not math.isnan(self._held)

    @property
    def held(self) -> float:
        """The force commanded last [N]; NaN before the start."""
        return self._held

    def due(self, now: int) -> bool:
        """Whether the last command is so old that it must be renewed well before it expires."""
        return self.started and elapsed_time(now, self._commanded) >= RENEWAL * self.limits.lifetime * NS

    def write_to(self, memory: NamedNumbers) -> None:
        """Put limits and state into a memory; policy and fail-safe do so themselves."""
        limits = self.limits
        memory["RULE_MIN_FORCE"], memory["RULE_MAX_FORCE"] = limits.min_force, limits.max_force
        memory["RULE_RAISE_RATE"], memory["RULE_LOWER_RATE"] = limits.raise_rate, limits.lower_rate
        memory["RULE_LIFETIME"] = limits.lifetime
        memory["SETUP_RENEWAL"] = math.ceil(RENEWAL * limits.lifetime * NS)
        memory["TURN_STARTED"], memory["GRIP_HELD"] = self.started, self._held
        memory["GRIP_REQUIRED"], memory["TURN_REASON"] = self.required_force, self.reason
        memory["TURN_COMMANDED"], memory["TURN_ASKED"] = self._commanded, self._asked
        memory["TURN_SEQ"] = self._seq

    def read_from(self, memory: NamedNumbers) -> None:
        """Take the state from where :meth:`write_to` puts it."""
        self._held = memory["GRIP_HELD"] if memory["TURN_STARTED"] else math.nan
        self.required_force, self.reason = memory["GRIP_REQUIRED"], Reason(int(memory["TURN_REASON"]))
        self._commanded, self._asked = int(memory["TURN_COMMANDED"]), int(memory["TURN_ASKED"])
        self._seq = int(memory["TURN_SEQ"])

    def standing_command(self) -> ForceCommand:
        """Return the last command; its adjustment is not kept."""
        expires = self._commanded + round(self.limits.lifetime * NS)
        return ForceCommand(self._commanded, self.finger, self._seq, self._held, 0.0, self.reason, expires)

    def number_from(self, seq: int) -> None:
        """Give the next command a number above ``seq``."""
        self._seq = max(self._seq, seq)

    def start(self, present: float, now: int) -> None:
        """Take over at the force ``present`` [N] that the finger has; NaN counts as none."""
        self._held = self.required_force = clamp_force(present, self.limits)
        self._commanded = self._asked = now
        self.policy.reset()
        self.fail_safe.recovered()

    def update(self, condition: Condition, demand: Demand, now: int) -> None:
        """Ask what this finger needs at ``now`` [ns]."""
        dt = max(0.0, elapsed_time(now, self._asked) / NS)
        self._asked = max(self._asked, now)
        if condition > Condition.DEGRADED:
            self._fault_response(dt, Reason.INPUT_HOLD)
            return
        base = self._held if demand.slipping or self.fail_safe.active else self.required_force
        force, reason = self.policy.wanted(base, demand, dt)
        if reason == Reason.UNTRUSTED or math.isnan(force):
            self._fault_response(dt, Reason.UNTRUSTED)
            return
        self.fail_safe.recovered()
        self.required_force = clamp_force(force, self.limits)
        self.reason = reason if self.required_force == force else _limit_reason(force, self.required_force)

    def command(self, share: float, now: int) -> ForceCommand:
        """Return the command for ``share`` [N], which is at least the need unless a fault is ridden out."""
        wanted = self.required_force if self.fail_safe.active else max(share, self.required_force)
        # Not longer than a command lives: after a silence the hand is on its own, and must not see a jump.
        dt = min(elapsed_time(now, self._commanded) / NS, self.limits.lifetime)
        force, reason = limit_force(wanted, self.reason, self._held, dt, self.limits)
        adjustment = force - self._held
        self._held, self._commanded = force, max(self._commanded, now)
        self._seq += 1
        expires = now + round(self.limits.lifetime * NS)
        return ForceCommand(now, self.finger, self._seq, force, adjustment, reason, expires)

    def _fault_response(self, dt: float, holding: Reason) -> None:
        # A rise that was asked for while all was well is completed: a fault must not cut it short.
        safe = max(self._held, self.required_force)
        self.policy.reset()
        self.required_force, self.reason = self.fail_safe.command(safe, dt, holding)


def _limit_reason(force: float, need: float) -> Reason:
    return Reason.MAX_LIMIT if force > need else Reason.MIN_LIMIT
