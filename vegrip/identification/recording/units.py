"""Units at the door: how a foreign column becomes SI. Inside vegrip there are no other units."""

import functools
import math
import re
import tokenize
from typing import Any, Final

from vegrip.errors import RecordingError

LONGEST_LENGTH: Final = 1.0
"""[m] No tip or probe is larger; a larger number is millimetres taken for metres."""

LARGEST_MASS: Final = 100.0
"""[kg] No hand lifts more; a larger number is grams taken for kilograms."""

LONGEST_NAME: Final = 100  # characters of a unit
MOST_POWERS: Final = 5
POWER: Final = re.compile(r"\*\*|\^")
PLAIN_POWER: Final = re.compile(r"\s*[-+]?\d(?:\.\d+)?(?![\d.eE_])(?!\s*(?:\*\*|\^))")
"""What may stand behind the sign of a power: one digit, and no power of it."""

SUPERSCRIPTS: Final = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹]{2}")
STRANGE: Final = (ArithmeticError, RecursionError, MemoryError, LookupError, AttributeError, AssertionError)


def to_si(unit: str, wanted: str, what: str) -> tuple[float, float]:
    """Return scale and offset so that ``value * scale + offset`` is ``value`` [unit] in ``wanted``.

    Args:
        unit: as people write it: ``mm``, ``mN``, ``uN``, ``degF``, ``N*mm``, ``gf``; empty means SI already.
        wanted: the SI unit of the quantity.
        what: the column, named in complaints.

    Raises:
        RecordingError: no such unit, or a unit of something else.

    """
    if not unit:
        return 1.0, 0.0
    offset = _convert(0.0, unit, wanted, what)
    return _convert(1.0, unit, wanted, what) - offset, offset


def is_unit(text: str) -> bool:
    """Whether ``text`` is a unit of anything, or the sign that there is none."""
    pint, units = _pint()
    if text in ("-", "1", "%"):
        return True
    try:
        return _is_plain(text) and bool(units.parse_units(text))
    except (pint.PintError, tokenize.TokenError, SyntaxError, ValueError, TypeError, *STRANGE):
        return False


def parse_length(text: str, what: str) -> float:
    """Return a length given as ``8 mm`` or as plain metres [m].

    Raises:
        RecordingError: no length, or none that a fingertip or probe has.

    """
    return _parsed(text, what, "length", "m", LONGEST_LENGTH, "8 mm")


def parse_mass(text: str, what: str) -> float:
    """Return a mass given as ``500 g`` or as plain kilograms [kg].

    Raises:
        RecordingError: no mass, or none that a hand lifts.

    """
    return _parsed(text, what, "mass", "kg", LARGEST_MASS, "500 g")


def _parsed(text: str, what: str, quantity: str, wanted: str, largest: float, example: str) -> float:
    number, unit = _split(text)
    try:
        value = float(number)
    except ValueError:
        raise RecordingError(f"{what} is {text!r}; give a {quantity} like {example!r}") from None
    found = _convert(value, unit, wanted, what) if unit else value
    if not 0.0 < found <= largest:
        raise RecordingError(
            f"{what} is {text!r}, which is {found:g} {wanted}; "
            f"give a {quantity} above 0 and up to {largest:g} {wanted}, like {example!r}"
        )
    return found


def _split(text: str) -> tuple[str, str]:
    unit = text.lstrip("0123456789.+-eE ")
    return text[: len(text) - len(unit)].strip(), unit.strip()


def _convert(value: float, unit: str, wanted: str, what: str) -> float:
    pint, units = _pint()
    unknown = RecordingError(
        f"{what}: there is no unit {unit[:60]!r}; write it like mm, mN, uN, ms, N*mm, degC"
    )
    if not _is_plain(unit):
        raise unknown
    try:
        converted = float(units.Quantity(value, units.parse_units(unit)).to(wanted).magnitude)
    except pint.DimensionalityError:
        weight = "; the weight of a gram is gf, of a kilogram kgf" if unit in ("g", "kg") else ""
        raise RecordingError(
            f"{what}: {unit!r} is not a unit of this quantity; it needs one like {wanted}{weight}"
        ) from None
    except (pint.PintError, tokenize.TokenError, SyntaxError, ValueError, TypeError, *STRANGE):
        raise unknown from None
    if not math.isfinite(converted):
        raise unknown
    return converted


def _is_plain(unit: str) -> bool:
    """Whether ``unit`` is short and its powers are of one digit: pint would compute 9**9**9**9 for ever."""
    powers = [match.end() for match in POWER.finditer(unit)]
    is_plain = all(PLAIN_POWER.match(unit, at) for at in powers)
    return (
        len(unit) <= LONGEST_NAME
        and len(powers) <= MOST_POWERS
        and is_plain
        and not SUPERSCRIPTS.search(unit)
    )


@functools.cache
def _pint() -> tuple[Any, Any]:
    """Import pint on first use: it takes longer than all of the command line."""
    import pint  # noqa: PLC0415

    return pint, pint.UnitRegistry()
