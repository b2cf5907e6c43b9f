"""Numbers and tables as text of C."""

import math

import numpy as np

from vegrip.c99.kinds import BOOL, INT, REAL, Kind

LARGEST = 2**31 - 1


def real(value: float) -> str:
    """Return a number as the shortest decimal that is read back as the same double."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "(-INFINITY)"
    return f"({value!r})" if math.copysign(1.0, value) < 0.0 else repr(value)


def whole(value: int) -> str:
    """Return a whole number.

    Raises:
        OverflowError: it does not fit into 32 bits.

    """
    if abs(value) > LARGEST:
        raise OverflowError(f"{value} does not fit into 32 bits")
    return str(value) if value >= 0 else f"({value})"


def hexadecimal(value: float) -> str:
    """Return a number to the bit, for test vectors."""
    return real(value) if not math.isfinite(value) else value.hex()


def table(values: object) -> tuple[Kind, tuple[int, ...], str]:
    """Return kind of the elements, shape and initialiser of a tuple or array of numbers.

    Raises:
        ValueError: it holds something else, or rows of unequal length.

    """
    array = np.asarray(values)
    if array.size == 0 or array.dtype.kind not in "fib":
        raise ValueError("a table holds numbers, in rows of equal length")
    kind = {"f": REAL, "i": INT, "b": BOOL}[array.dtype.kind]
    return kind, array.shape, _rows(array, kind)


def _rows(array: np.ndarray[tuple[int, ...], np.dtype[np.generic]], kind: Kind) -> str:
    if array.ndim > 1:
        return "{" + ", ".join(_rows(row, kind) for row in array) + "}"
    return "{" + ", ".join(_element(one, kind) for one in array.tolist()) + "}"


def _element(one: float, kind: Kind) -> str:
    if kind == BOOL:
        return "true" if one else "false"
    return real(one) if kind == REAL else whole(int(one))
