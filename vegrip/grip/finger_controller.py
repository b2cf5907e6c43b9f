"""The control of one finger: policy, fail-safe, limits, and the command that comes out."""

import math

from vegrip.clock import NS
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.policy import GripPolicy
from vegrip.grip.safety.fail_safe import FailSafe
from vegrip.grip.safety.limits import LimitSettings, clamped, limited
from vegrip.messages import Condition, ForceCommand, Reason

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
        self.need = 0.0  # [N]
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
        return self.started and now - self._commanded >= RENEWAL * self.limits.lifetime * NS

    def start(self, present: float, now: int) -> None:
        """Take over at the force ``present`` [N] that the finger has; NaN counts as none."""
        self._held = self.need = clamped(present, self.limits)
        self._commanded = self._asked = now
        self.policy.reset()
        self.fail_safe.recovered()

    def want(self, condition: Condition, demand: Demand, now: int) -> None:
        """Ask what this finger needs at ``now`` [ns]."""
        dt = max(0.0, (now - self._asked) / NS)
        self._asked = max(self._asked, now)
        if condition > Condition.DEGRADED:
            self._ride_out(dt, Reason.INPUT_HOLD)
            return
        base = self._held if demand.slipping or self.fail_safe.active else self.need
        force, reason = self.policy.wanted(base, demand, dt)
        if reason == Reason.UNTRUSTED or math.isnan(force):
            self._ride_out(dt, Reason.UNTRUSTED)
            return
        self.fail_safe.recovered()
        self.need = clamped(force, self.limits)
        self.reason = reason if self.need == force else _limit(force, self.need)

    def command(self, share: float, now: int) -> ForceCommand:
        """Return the command for ``share`` [N], which is at least the need unless a fault is ridden out."""
        wanted = self.need if self.fail_safe.active else max(share, self.need)
        # Not longer than a command lives: after a silence the hand is on its own, and must not see a jump.
        dt = min((now - self._commanded) / NS, self.limits.lifetime)
        force, reason = limited(wanted, self.reason, self._held, dt, self.limits)
        adjustment = force - self._held
        self._held, self._commanded = force, max(self._commanded, now)
        self._seq += 1
        expires = now + round(self.limits.lifetime * NS)
        return ForceCommand(now, self.finger, self._seq, force, adjustment, reason, expires)

    def _ride_out(self, dt: float, holding: Reason) -> None:
        # A rise that was asked for while all was well is completed: a fault must not cut it short.
        safe = max(self._held, self.need)
        self.policy.reset()
        self.need, self.reason = self.fail_safe.command(safe, dt, holding)


def _limit(force: float, need: float) -> Reason:
    return Reason.MAX_LIMIT if force > need else Reason.MIN_LIMIT
