"""Where a formula holds: arguments are checked on the way in, with the offending value in the complaint."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vegrip.errors import DomainError
from vegrip.types import Floats


def within(name: str, values: ArrayLike, low: float, high: float, unit: str = "") -> Floats:
    """Return ``values`` as doubles; NaN or anything outside ``low .. high`` raises :class:`DomainError`."""
    array = np.asarray(values, dtype=np.float64)
    good = (array >= low) & (array <= high)
    if not good.all():
        raise DomainError(
            f"{name} is {_first(array, good)}; it must lie in {low:g} .. {high:g} {unit}".rstrip()
        )
    return array


def positive(name: str, values: ArrayLike, unit: str = "") -> Floats:
    """Return ``values`` as doubles; NaN, zero and less raise :class:`DomainError`. Infinity is allowed."""
    array = np.asarray(values, dtype=np.float64)
    good = array > 0
    if not good.all():
        raise DomainError(f"{name} is {_first(array, good)}; it must be more than 0 {unit}".rstrip())
    return array


def not_negative(name: str, values: ArrayLike, unit: str = "") -> Floats:
    """Return ``values`` as doubles; NaN and anything below zero raise :class:`DomainError`."""
    array = np.asarray(values, dtype=np.float64)
    good = array >= 0
    if not good.all():
        raise DomainError(f"{name} is {_first(array, good)}; it must not be less than 0 {unit}".rstrip())
    return array


def _first(array: Floats, good: NDArray[np.bool_]) -> str:
    return f"{array[~good].flat[0]:g}"
