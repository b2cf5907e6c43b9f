"""Numbers and tables as text of C."""

import math

import numpy as np

from vegrip.c99.kinds import BOOL, DOUBLE, FLOAT, INT, REAL, Kind, RealType

MAX_INT32 = 2**31 - 1
LARGEST_LONG = 2**63 - 1
SMALLEST_FLOAT = 1e-30
"""What a constant nearer to 0 becomes in single precision: its reciprocal is a float as well."""
HUGE = 1e30
"""What a larger constant becomes in single precision."""


def real(value: float, reals: RealType = DOUBLE) -> str:
    """Return a number as the shortest decimal that is read back as the same double."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "(-INFINITY)"
    text = f"{in_range(value) if reals == FLOAT else value!r}{reals.literal}"
    return f"({text})" if math.copysign(1.0, value) < 0.0 else text


def in_range(value: float) -> float:
    """Return a finite number brought into the range in which a float and its reciprocal exist.

    A float keeps seven digits whatever its size, so numbers of any unit fit as they are. Where a text needs
    eight digits or more, single precision is not for it.
    """
    size = abs(value)
    if size == 0.0 or SMALLEST_FLOAT <= size <= HUGE:
        return value
    return math.copysign(SMALLEST_FLOAT if size < SMALLEST_FLOAT else HUGE, value)


def whole(value: int) -> str:
    """Return a whole number."""
    if abs(value) > LARGEST_LONG:
        raise OverflowError(f"{value} does not fit into 64 bits")
    text = str(value) if is_short(value) else f"{value}LL"
    return text if value >= 0 else f"({text})"


def is_short(value: int) -> bool:
    return abs(value) <= MAX_INT32


def hexadecimal(value: float) -> str:
    return real(value) if not math.isfinite(value) else value.hex()


def table(values: object, reals: RealType = DOUBLE) -> tuple[Kind, tuple[int, ...], str]:
    """Return kind of the elements, shape and initialiser of a tuple or array of numbers."""
    array = np.asarray(values)
    if array.size == 0 or array.dtype.kind not in "fib":
        raise ValueError("a table holds numbers, in rows of equal length")
    kind = {"f": REAL, "i": INT, "b": BOOL}[array.dtype.kind]
    return kind, array.shape, _rows(array, kind, reals)


def _rows(array: np.ndarray[tuple[int, ...], np.dtype[np.generic]], kind: Kind, reals: RealType) -> str:
    if array.ndim > 1:
        return "{" + ", ".join(_rows(row, kind, reals) for row in array) + "}"
    return "{" + ", ".join(_element(one, kind, reals) for one in array.tolist()) + "}"


def _element(one: float, kind: Kind, reals: RealType) -> str:
    if kind == BOOL:
        return "true" if one else "false"
    if kind == INT and not is_short(int(one)):
        raise ValueError(f"{one} does not fit into 32 bits")
    return real(one, reals) if kind == REAL else whole(int(one))
