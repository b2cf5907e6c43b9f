"""One way to compile: numba in nopython mode, cached on disk, with numpy's rules for division by zero."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., object])


def njit(function: F) -> F:
    """Compile ``function`` on first use.

    Trap: numba's disk cache looks only at the file of the function itself. A compiled function must not
    call compiled functions of another module, or edits there run stale code in silence; code generated
    from several sources goes into one file named by the hash of its content.
    """
    return cast("F", numba.njit(cache=True, error_model="numpy", nogil=True)(function))
