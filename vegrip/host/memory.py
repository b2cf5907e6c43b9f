"""Memory that is free goes back to the system."""

import ctypes
import gc
import sys

MANY_ROWS = 20_000  # of arrays, from which on what they leave is worth a tenth of a second


def give_back_memory(rows: int = MANY_ROWS) -> None:
    """Let the C library give back what arrays of so many ``rows`` have left free between each other.

    It keeps that for later arrays, of which few fit: of a diagnosis of 100 000 rows a hundred megabytes in
    each round. What refers to itself is collected first. Nothing is done where it is not worth the time.
    """
    if rows < MANY_ROWS:
        return
    gc.collect()
    library = ctypes.CDLL(None) if sys.platform == "linux" else None
    trim = getattr(library, "malloc_trim", None)  # of the GNU library alone
    if trim is not None:
        trim(0)
