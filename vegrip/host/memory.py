"""Memory that is free goes back to the system."""

import ctypes
import sys


def give_back_memory() -> None:
    """Let the C library give back what arrays of many sizes have left free between each other, where it can.

    It keeps that for later arrays, of which few fit: of a diagnosis of 100 000 rows a hundred megabytes in
    each round.
    """
    library = ctypes.CDLL(None) if sys.platform == "linux" else None
    trim = getattr(library, "malloc_trim", None)  # of the GNU library alone
    if trim is not None:
        trim(0)
