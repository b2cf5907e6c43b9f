"""A grip policy of another package: a fixed multiple of the load.

The package offers it in its ``pyproject.toml``::

    [project.entry-points."vegrip.policies"]
    proportional = "my_policy:POLICY"

and a launch file chooses it::

    parameters.policy = "proportional"
    parameters.policy_settings = { gain = 5.0 }
"""

from dataclasses import dataclass

from vegrip.config import parameter
from vegrip.grip.policies import PolicyKind
from vegrip.grip.policies.demand import Demand
from vegrip.messages import Reason


@dataclass(frozen=True)
class ProportionalSettings:
    """What a launch file may set."""

    gain: float = parameter(4.0, unit="1", low=0.0, high=100.0, doc="force over load")


class Proportional:
    """A fixed multiple of the tangential force."""

    uses_least_force = False  # does not look at demand.least_force, which costs the most

    def __init__(self, settings: ProportionalSettings) -> None:
        self.settings = settings

    def reset(self) -> None:
        """Nothing to forget."""

    def wanted(self, held: float, demand: Demand, dt: float) -> tuple[float, Reason]:  # noqa: ARG002
        """Return the wanted force [N] and its reason."""
        force = self.settings.gain * demand.tangential_force
        return force, Reason.RAISE if force > held else Reason.LOWER


POLICY = PolicyKind(Proportional, ProportionalSettings)
