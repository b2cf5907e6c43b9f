"""The functions of ``math`` by the arithmetic of compiled code, for generated modules that run uncompiled.

Compiled code follows IEEE 754: ``exp(1000)`` is inf, ``log(0)`` -inf, ``sqrt(-1)`` and ``inf - inf`` NaN, and
a division by zero inf or NaN. Python raises instead. Here every function takes and gives ``np.float64``,
whose arithmetic is that of compiled code too; ``uncompiled`` brings the numbers of a call into it.
"""

import functools
import math
from collections.abc import Callable
from math import copysign, inf, isfinite, isinf, isnan, nan, pi
from typing import Any

import numpy as np

__all__ = ["copysign", "inf", "isfinite", "isinf", "isnan", "nan", "pi", "uncompiled"]

Function = Callable[..., Any]
LIMITS: dict[str, Function] = {"pow": np.power}
"""numpy's functions that have another name; they say what comes where ``math`` raises."""
OTHERWISE: dict[str, Function] = {"hypot": np.hypot}
"""numpy's functions that round as the C library does where ``math`` does not. (``np.power`` may be
written for the vector units of this processor.)"""


def uncompiled(*, cache: bool = False, **_options: Any) -> Callable[[Function], Function]:
    """Stand in for ``numba.njit``: a function that Python calls (``cache``) computes by IEEE 754."""

    def decorate(function: Function) -> Function:
        return _entered(function) if cache else function

    return decorate


def _entered(function: Function) -> Function:
    @functools.wraps(function)
    def entry(*arguments: Any) -> Any:
        with np.errstate(all="ignore"):
            return function(*[np.float64(a) if isinstance(a, float) else a for a in arguments])

    return entry


def __getattr__(name: str) -> Function:
    exact: Function = OTHERWISE[name] if name in OTHERWISE else getattr(math, name)
    limit: Function = LIMITS[name] if name in LIMITS else getattr(np, name, exact)

    def function(*arguments: Any) -> Any:
        try:
            return np.float64(exact(*arguments))
        except (ValueError, OverflowError):
            return limit(*[np.float64(a) for a in arguments])

    globals()[name] = function
    return function
