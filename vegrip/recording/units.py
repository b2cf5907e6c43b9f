"""Units at the door: how a foreign column becomes SI. Inside vegrip there are no other units."""

import functools
import tokenize
from typing import Any, Final

from vegrip.errors import RecordingError

LONGEST: Final = 1.0
"""[m] No tip or probe is larger; a larger number is millimetres taken for metres."""


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


def parse_length(text: str, what: str) -> float:
    """Return a length given as ``8 mm`` or as plain metres [m].

    Raises:
        RecordingError: no length, or none that a fingertip or probe has.

    """
    number, unit = _split(text)
    try:
        value = float(number)
    except ValueError:
        raise RecordingError(f"{what} is {text!r}; give a length like '8 mm'") from None
    metres = _convert(value, unit, "m", what) if unit else value
    if not 0.0 < metres <= LONGEST:
        raise RecordingError(
            f"{what} is {text!r}, which is {metres:g} m; "
            f"give a length above 0 and up to {LONGEST:g} m, like '8 mm'"
        )
    return metres


def _split(text: str) -> tuple[str, str]:
    unit = text.lstrip("0123456789.+-eE ")
    return text[: len(text) - len(unit)].strip(), unit.strip()


def _convert(value: float, unit: str, wanted: str, what: str) -> float:
    pint, units = _pint()
    try:
        return float(units.Quantity(value, units.parse_units(unit)).to(wanted).magnitude)
    except pint.DimensionalityError:
        raise RecordingError(
            f"{what}: {unit!r} is not a unit of this quantity; it needs one of {wanted}"
        ) from None
    except (pint.PintError, tokenize.TokenError, SyntaxError, ValueError, TypeError, AttributeError):
        raise RecordingError(
            f"{what}: there is no unit {unit!r}; write it like mm, mN, uN, ms, N*mm, degC"
        ) from None


@functools.cache
def _pint() -> tuple[Any, Any]:
    """Import pint on first use: it takes longer than all of the command line."""
    import pint  # noqa: PLC0415

    return pint, pint.UnitRegistry()
