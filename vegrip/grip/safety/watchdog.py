"""When the input of a finger stops being believed (:mod:`vegrip.grip.kernels.watchdog` has what is seen)."""

from dataclasses import dataclass, field

from vegrip.config import parameter
from vegrip.grip.safety.ranges import Ranges

MECHANICAL = ("normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "displacement")


@dataclass(frozen=True)
class WatchdogSettings:
    """When input stops being believed."""

    time_out: float = parameter(0.05, unit="s", low=0.001, high=10.0, doc="input older than this is stale")
    frozen_after: float = parameter(
        0.25, unit="s", low=0.01, high=3600.0, doc="all values the same for so long: frozen"
    )
    force_frozen_after: float = parameter(
        2.0, unit="s", low=0.01, high=3600.0, doc="the same of the normal force alone"
    )
    frozen_chance: float = parameter(
        1e-7,
        unit="1",
        low=0.0,
        high=0.01,
        doc="frozen at once when a noisy normal force repeats itself more often than with this chance",
    )
    doubt_after: float = parameter(
        0.05,
        unit="s",
        low=0.001,
        high=3600.0,
        doc="normal force the same for so long: not lowered on its word",
    )
    stuck_travel: float = parameter(
        3e-4,
        unit="m",
        low=1e-6,
        high=1.0,
        doc="frozen when the normal force stands still while the tip is pressed in or let go by more",
    )
    recover_after: int = parameter(5, unit="states", low=1, high=1000, doc="good states that end a fault")
    ranges: Ranges = field(default_factory=Ranges)
