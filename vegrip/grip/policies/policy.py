"""What every grip policy answers: which force is wanted, and why."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from vegrip.grip.policies.demand import Demand
from vegrip.messages import Reason


class GripPolicy(Protocol):
    """A rule from the demand of one finger to the wanted grip force.

    A policy may keep memory of its own (a slow release, say), but knows no clock, limit or fault: those
    are the stages after it.
    """

    settings: Any
    """As its :class:`PolicyKind` says; replaced while it runs."""
    uses_least_force: bool
    """Whether it looks at :attr:`Demand.least_force`, the one costly part of a demand."""

    def wanted(self, held: float, demand: Demand, dt: float) -> tuple[float, Reason]:
        """Return the wanted normal force [N] and its reason.

        Args:
            held: force commanded last [N].
            demand: what the finger needs.
            dt: time since the last call [s], >= 0.

        """

    def reset(self) -> None:
        """Forget the past."""


@dataclass(frozen=True)
class PolicyKind:
    """A kind of policy, as it is found by its name.

    Args:
        make: gives a new policy for its settings, one for each finger. The policy keeps them as ``settings``,
            where new ones are put while it runs. None: the finger step has it.
        settings: type of ``policy_settings``, a frozen dataclass of :func:`vegrip.config.parameter` fields.

    """

    make: Callable[[Any], GripPolicy] | None
    settings: type[Any]
