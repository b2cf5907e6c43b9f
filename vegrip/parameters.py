"""Physical parameters: declared once with unit, range and prior; the filter sees them transformed.

A parameter is learned and stored in its *coordinate*: its logarithm where only its order of magnitude is
known beforehand (stiffness, rates, friction), itself otherwise. Standard deviations are those of the
coordinate: ``std = 0.1`` of a logarithmic parameter means ten percent.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Final, Literal

from vegrip.errors import ModelError

Transform = Literal["identity", "log"]

SCALES: Final = {
    "K": ("N", 1, 0),
    "K/s": ("N/s", 1, 0),
    "x_ref": ("m", 0, 1),
    "x_ref/s": ("m/s", 0, 1),
    "x_ref/K": ("m/N", -1, 1),
    "K/x_ref": ("N/m", 1, -1),
    "K s^2/x_ref": ("kg", 1, -1),
}
"""What scaled values are multiples of: its SI unit, and its powers of K [N], the force at the reference depth
x_ref [m], and of x_ref."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """What an effect declares of one of its parameters."""

    symbol: str  # as in the formula, a Python identifier, unique within a model
    unit: str  # SI, "1" = dimensionless
    default: float
    std: float  # prior standard deviation of the coordinate
    low: float  # bounds of the value
    high: float
    doc: str
    transform: Transform = "identity"
    null: float | None = None  # the value at which the effect is absent; None = a part of the base model
    learn: bool = False  # the online estimator may change it
    drift: float = 0.0  # random walk of the coordinate while it is learned [1/sqrt(s)]
    of: str = ""  # what a value is a multiple of: one of SCALES


@dataclass(frozen=True, slots=True)
class Value:
    """A parameter in a model: its present value and how well it is known."""

    value: float
    std: float  # of the coordinate
    low: float
    high: float
    learn: bool


def in_si(parameter: Parameter, value: float, K: float, x_ref: float) -> tuple[float, str] | None:
    """Return a scaled value in SI, with its unit; None where it is no multiple of anything."""
    if parameter.of not in SCALES:
        return None
    unit, of_K, of_x = SCALES[parameter.of]
    return value * K**of_K * x_ref**of_x, unit


def declared(parameter: Parameter) -> Value:
    """Return the value a model starts with: default and prior."""
    return Value(parameter.default, parameter.std, parameter.low, parameter.high, parameter.learn)


def absolute(parameter: Parameter, value: float, std: float) -> float:
    """Return the standard deviation of a value in its unit, from that of its coordinate."""
    return std * value if parameter.transform == "log" else std


def coordinate(parameter: Parameter, value: float) -> float:
    return math.log(value) if parameter.transform == "log" else value


def check(effect: str, parameter: Parameter, value: Value) -> None:
    """Refuse a value outside its bounds, or bounds outside those the effect declares.

    Raises:
        ModelError: names effect, parameter and range.

    """
    name = f"{effect}: {parameter.symbol}"
    if not parameter.low <= value.low <= value.high <= parameter.high:
        allowed = f"{parameter.low:g} .. {parameter.high:g} {parameter.unit}"
        raise ModelError(f"{name} has bounds {value.low:g} .. {value.high:g}; choose them within {allowed}")
    if not value.low <= value.value <= value.high:  # NaN fails too
        bounds = f"{value.low:g} .. {value.high:g} {parameter.unit}"
        raise ModelError(f"{name} is {value.value:g}, outside its bounds; choose it in {bounds}")
    if not 0.0 <= value.std < math.inf:
        raise ModelError(
            f"{name} has the standard deviation {value.std:g}; it must be finite and not negative"
        )


def changed(known: Value, /, **fields: float | bool) -> Value:
    return dataclasses.replace(known, **fields)  # type: ignore[arg-type]
