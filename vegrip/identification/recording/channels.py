"""The columns of a recording: name, unit, and between which bounds a fingertip's value is plausible.

The bounds serve one purpose, to notice a wrong unit: a force of 1200 is millinewtons taken for newtons,
a temperature of 298 is kelvin. They are wide on purpose (nanoindenter to human grip) and nothing is thrown
away because of them.
"""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Quantity:
    """Unit and plausible range of one column, SI; temperature in degrees Celsius."""

    unit: str
    low: float
    high: float


CHANNELS: Final[dict[str, Quantity]] = {
    "displacement": Quantity("m", -0.05, 0.05),
    "normal_force": Quantity("N", -500.0, 500.0),
    "tangential_force_x": Quantity("N", -500.0, 500.0),
    "tangential_force_y": Quantity("N", -500.0, 500.0),
    "torque_z": Quantity("N m", -20.0, 20.0),
    "slip": Quantity("1", 0.0, 1.0),
    "slip_speed": Quantity("m/s", -5.0, 5.0),
    "temperature": Quantity("degC", -60.0, 200.0),
    "contact_radius": Quantity("m", -0.005, 0.05),
}
"""What a fingertip measures, in the order in which a recording is written."""

RECORDED: Final = CHANNELS | {"age": Quantity("s", 0.0, 1e12)}
"""What a recording may hold besides ``t`` [s] and ``episode``: also how old the material is."""

STEP_QUANTITIES: Final = {"modulus": Quantity("Pa", 0.0, 1e12), "compliance": Quantity("1/Pa", 0.0, 1e6)}
"""What a unit step shows: the stress of a strain that is held, the strain of a stress that is held."""

STRETCHES: Final = {"strain": Quantity("1", -1.0, 100.0), "stress": Quantity("Pa", -1e12, 1e12)}
"""What a specimen shows that is stretched or pressed as a whole: length and tension, over those at rest."""

IMPORTED: Final = RECORDED | STEP_QUANTITIES | STRETCHES
"""What a column of a table may be."""

NOISE_NAMES: Final = (
    "normal_force",
    "displacement",
    "tangential_force",
    "torque_z",
    "slip_speed",
    "temperature",
    "contact_radius",
)
"""Names of ``[sensors]``: standard deviations; both tangential components share one."""


def noise_name(channel: str) -> str:
    """Return under which name ``[sensors]`` keeps the noise of ``channel``."""
    return "tangential_force" if channel.startswith("tangential_force") else channel
