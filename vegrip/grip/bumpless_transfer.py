"""Bumpless transfer: a finger whose contact is met in its middle goes on with the force that is there.

An estimator that has not seen a contact begin knows little of it, and its first samples may ask for several
times the force that is needed. What is known without it: the load of that instant is held, by the normal
force of that instant. So for ``TRANSFER_DURATION_S`` the least force is bounded by what this shows::

    bound = max(N0 g^2, min(N0 + ramp_rate t, fail-safe force)),    g = max(1, load / load at the beginning)

The load is ``hypot(f_t, m / a)``. Coulomb's friction needs ``N0 g``; the friction coefficient of soft tips
falls as the normal force grows, hardly faster than with its square root, and then ``N0 g^2`` is needed.
Slip ends it at once: then what was held is held no more.
"""

import math

from vegrip.clock import NS
from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.policies.demand import Demand
from vegrip.grip.safety.fail_safe import FailSafeSettings
from vegrip.types import NamedNumbers

TRANSFER_DURATION_S = 0.3
"""[s] after which the estimate rules whatever it says; within 0.1 s it has mostly settled."""


class BumplessTransfer:
    """The bound of one finger's least force after its contact was met."""

    def __init__(self) -> None:
        self._since: int | None = None  # [ns]; None = not under way
        self._force = self._load = self._arm = math.nan

    def begin(self, force: float, demand: Demand, arm: float, now: int) -> None:
        """Take over at ``now`` [ns] with ``force`` [N], which holds the load of ``demand``.

        ``arm`` [m] makes a force of the torque, the contact radius; NaN leaves the torque out.
        """
        self._since, self._force, self._arm = now, force, arm
        self._load = self._load_of(demand)

    def bounded(self, least: float, demand: Demand, now: int, ramp: FailSafeSettings) -> float:
        """Return ``least`` [N], or less while what is held shows that less suffices; NaN stays NaN."""
        if self._since is None:
            return least
        elapsed = elapsed_time(now, self._since) / NS
        if demand.slipping or not 0.0 <= elapsed < TRANSFER_DURATION_S:
            self._since = None
            return least
        growth = self._growth(demand)
        held = self._force * growth * growth
        ramped = min(self._force + ramp.ramp_rate * elapsed, ramp.force)
        return min(least, max(held, ramped))  # this order: min(nan, x) is nan

    def write_to(self, memory: NamedNumbers) -> None:
        """Put everything into a memory."""
        memory["TURN_IN_TRANSFER"], memory["TURN_TRANSFER_SINCE"] = self._since is not None, self._since or 0
        memory["TRANSFER_FORCE"], memory["TRANSFER_LOAD"] = self._force, self._load
        memory["TRANSFER_ARM"] = self._arm

    def read_from(self, memory: NamedNumbers) -> None:
        """Take everything from where :meth:`write_to` puts it."""
        self._since = int(memory["TURN_TRANSFER_SINCE"]) if memory["TURN_IN_TRANSFER"] else None
        self._force, self._load = memory["TRANSFER_FORCE"], memory["TRANSFER_LOAD"]
        self._arm = memory["TRANSFER_ARM"]

    def _growth(self, demand: Demand) -> float:
        load = self._load_of(demand)
        if self._load > 0.0:
            return max(1.0, load / self._load)
        return math.inf if load > 0.0 else 1.0  # no load, or an unmeasured one, shows nothing

    def _load_of(self, demand: Demand) -> float:
        turning = demand.torque / self._arm if self._arm > 0.0 else 0.0
        turning = 0.0 if math.isnan(turning) else turning
        # not math.hypot: Python's rounds otherwise than C's
        return math.sqrt(demand.tangential_force * demand.tangential_force + turning * turning)
