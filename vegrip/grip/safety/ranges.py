"""The range within which each measured quantity can be true; outside it the sensor, or the wire, lies."""

import dataclasses
from dataclasses import dataclass
from operator import attrgetter

from vegrip.config import parameter
from vegrip.errors import ConfigError


def _range(low: float, high: float, unit: str) -> tuple[float, float]:
    declared: tuple[float, float] = parameter(
        (low, high), unit=unit, doc="least and largest believable value"
    )
    return declared


@dataclass(frozen=True)
class Ranges:
    """Believable ranges, named as the channels of :class:`~vegrip.messages.FingertipState`."""

    normal_force: tuple[float, float] = _range(-5.0, 60.0, "N")
    tangential_force_x: tuple[float, float] = _range(-60.0, 60.0, "N")
    tangential_force_y: tuple[float, float] = _range(-60.0, 60.0, "N")
    torque_z: tuple[float, float] = _range(-2.0, 2.0, "N m")
    displacement: tuple[float, float] = _range(-0.05, 0.02, "m")
    temperature: tuple[float, float] = _range(-40.0, 150.0, "degrees Celsius")
    slip: tuple[float, float] = _range(0.0, 1.0, "1")
    slip_speed: tuple[float, float] = _range(-10.0, 10.0, "m/s")
    contact_radius: tuple[float, float] = _range(0.0, 0.05, "m")

    def __post_init__(self) -> None:
        for name in CHECKED_CHANNELS:
            bounds = getattr(self, name)
            if len(bounds) != 2 or not bounds[0] < bounds[1]:
                raise ConfigError(f"ranges: {name!r} is {list(bounds)}; it must be [least, largest]")


CHECKED_CHANNELS = tuple(field.name for field in dataclasses.fields(Ranges))
"""The measured quantities of a fingertip, by name."""

bounds_of = attrgetter(*CHECKED_CHANNELS)
"""Their ranges: the fields of :class:`Ranges` have the same names."""
