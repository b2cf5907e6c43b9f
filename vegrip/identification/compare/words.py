"""Numbers as people say them: 40 mN, 0.3 mm, 5 mm/s."""

import math
from typing import Final

UNITS: Final = {
    "normal_force": "N",
    "tangential_force": "N",
    "displacement": "m",
    "indentation": "m",
    "contact_radius": "m",
    "torque_z": "N m",
    "speed": "m/s",
    "slip_speed": "m/s",
    "time": "s",
    "time_in_contact": "s",
    "time_in_episode": "s",
    "temperature": "degC",
    "frequency": "Hz",
    "episode": "",
}
SAID: Final = {
    "normal_force": "at {} of normal force",
    "tangential_force": "at {} of tangential force",
    "indentation": "at a depth of {}",
    "speed": "at {}",
    "time": "{} after the start",
    "time_in_contact": "{} into the contact",
    "time_in_episode": "{} into the episode",
    "temperature": "at {}",
    "frequency": "at {}",
    "episode": "in episode {}",
}
PREFIX: Final = {-3: "n", -2: "u", -1: "m", 0: "", 1: "k"}


def quantity(name: str, value: float) -> str:
    """Return ``value`` with its unit, two digits."""
    unit = UNITS.get(name, "")
    if unit in ("", "degC", "s", "Hz") or value == 0.0:
        return f"{value:.0f} {unit}".strip() if abs(value) >= 100.0 else f"{value:.2g} {unit}".strip()
    power = min(max(math.floor(math.log10(abs(value)) / 3.0), -3), 1)
    if unit.startswith("m") and power == 1:
        power = 0
    scaled = value / 10.0 ** (3 * power)
    digits = f"{scaled:.2g}" if abs(scaled) < 100.0 else f"{scaled:.0f}"
    return f"{digits} {PREFIX[power]}{unit}"


def span(name: str, low: float | None, high: float | None) -> str:
    """Return a range in words."""
    if name == "frequency" and not low:
        return "without going to and fro" if low is None else "while going to and fro"
    if low is None and high is not None:
        text = f"up to {quantity(name, high)}"
    elif high is None and low is not None:
        text = f"more than {quantity(name, low)}"
    elif low is not None and high is not None:
        text = f"{quantity(name, low)} to {quantity(name, high)}"
    else:
        text = "any"
    return SAID.get(name, f"{name} {{}}").format(text)


def height(low: float | None, high: float | None) -> str:
    """Return a range of depths out of contact in words: heights above the surface at rest."""
    if high is not None and high >= 0.0:
        return span("indentation", low, high)
    if low is not None and high is None:
        if low >= 0.0:
            return span("indentation", low, high)
        return f"closer than {quantity('indentation', -low)} to the surface"
    if low is None and high is not None:
        return f"more than {quantity('indentation', -high)} from the surface"
    if low is not None and high is not None:
        return f"{quantity('indentation', -high)} to {quantity('indentation', -low)} from the surface"
    return span("indentation", low, high)
