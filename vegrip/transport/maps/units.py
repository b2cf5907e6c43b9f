"""Units of a foreign hand -> SI, with the spellings that data sheets and DBC files have."""

import re
from typing import Final

from vegrip.errors import ConfigError, RecordingError
from vegrip.identification.recording.units import to_si

SI: Final = {
    "normal_force": "N",
    "tangential_force_x": "N",
    "tangential_force_y": "N",
    "tangential_magnitude": "N",
    "tangential_direction": "rad",
    "torque_x": "N*m",
    "torque_y": "N*m",
    "torque_z": "N*m",
    "displacement": "m",
    "temperature": "degC",
    "slip": "",
    "slip_speed": "m/s",
    "contact_radius": "m",
    "device_slip_state": "",
    "device_friction": "",
    "device_grip_force": "N",
}
"""The unit of each channel; torque_x and torque_y only serve to turn the frame, and magnitude and
direction (from our x towards our y) only to make the tangential forces x and y. What begins with device_ is
what a device says of its contact itself: it is reported beside ours, and nothing rests on it."""

SPELLINGS: Final = {
    spelling: unit
    for unit, spellings in {
        "N*m": ("Nm",),
        "mN*m": ("mNm",),
        "uN*m": ("uNm",),
        "N*cm": ("Ncm",),
        "N*mm": ("Nmm",),
        "gf*cm": ("gcm",),
        "deg": ("°", "degree", "degrees", "DEG"),
        "degC": ("°C", "C", "Celsius"),
        "rad": ("RAD",),
        "A": ("Amps", "Amp"),
        "gf": ("grams", "gram", "g"),
        "kgf": ("kg",),
        "lbf": ("lb", "lbs"),
        "ozf": ("oz",),
        "N": ("Newton", "Newtons"),
        "um": ("µm",),
        "count": ("cnt", "cnts", "counts", "digit", "digits", "LSB", "lsb", "raw", "ticks", "tick"),
    }.items()
    for spelling in spellings
}
"""How units are spelled -> what pint reads. ``Nm`` would be no unit and ``g`` a mass; where a force is
wanted, grams are the weight of grams."""

QUANTITY: Final = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\D.*)?", re.DOTALL)


def conversion(unit: str, wanted: str, what: str) -> tuple[float, float]:
    """Return scale and offset from ``unit`` to the SI unit ``wanted``; an empty unit is SI already."""
    if not unit.strip() or not wanted:
        return 1.0, 0.0
    try:
        return to_si(SPELLINGS.get(unit.strip(), unit.strip()), wanted, what)
    except RecordingError as error:
        raise ConfigError(str(error)) from None


def is_force(unit: str) -> bool:
    """Whether ``unit`` is one of force; an empty one is newtons."""
    try:
        conversion(unit, "N", "unit")
    except ConfigError:
        return False
    return True


def quantity(text: str, what: str) -> tuple[float, str]:
    """Return number and unit of a text like ``2.5 N/A``."""
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise ConfigError(f"{what} is {text[:60]!r}; it must be a number and a unit, like '2.5 N/A'")
    return float(match[1]), (match[2] or "").strip()


def worth(unit: str, gain: str, wanted: str, what: str) -> tuple[float, float]:
    """Return scale and offset from ``unit`` to ``wanted``; a ``gain`` ('2.5 N/A') leads elsewhere."""
    if not gain:
        return conversion(unit, wanted, f"{what}: 'unit'")
    number, per = quantity(gain, f"{what}: 'gain'")
    scale, offset = conversion(product(unit, per), wanted, f"{what}: 'gain'")
    return number * scale, offset


def in_si(text: str, wanted: str, what: str) -> float:
    """Return the value of ``text`` ('1.5 N') in the SI unit ``wanted``."""
    number, unit = quantity(text, what)
    scale, offset = conversion(unit, wanted, what)
    return number * scale + offset


def product(unit: str, factor: str) -> str:
    """Return the unit of a value in ``unit`` times a factor in ``factor``, as pint reads it."""
    one, other = (SPELLINGS.get(each.strip(), each.strip()) for each in (unit, factor))
    if "/" in other:
        above, below = (SPELLINGS.get(part.strip(), part.strip()) for part in other.split("/", 1))
        other = f"({above or '1'})/({below})"
    return f"({one or '1'})*({other or '1'})"
