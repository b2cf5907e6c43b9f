"""The estimator's kernels compiled by the C compiler of this machine, in place of numba's."""

import ctypes
from typing import Final

from vegrip.c99 import LONGS, MEMORY, REAL
from vegrip.c99.names import Place, unknown_place
from vegrip.model import native

ENTRIES: Final[native.Entries] = {
    "update": (MEMORY, *[REAL] * 7),
    "filter_step": (MEMORY, *[REAL] * 4),
    "margin_of": (MEMORY, REAL, REAL, MEMORY),
    "least_force": (MEMORY, *[REAL] * 4),
    "look_at_cells": (MEMORY, REAL, MEMORY),
    "assimilate": (MEMORY, LONGS),
}
"""What is called from outside, with the kinds of its arguments."""
WRITTEN: Final = {"margin_of": 5, "look_at_cells": 6}
"""How many numbers an entry writes besides the memory."""


def load(text: str, place: Place = unknown_place, *, single: tuple[int, int] | None = None) -> native.ModuleC:
    """Return the kernels of a generated module's ``text``, from the cache or compiled now.

    With ``single``, the lengths of the filter's memory and of the whole one, they compute in single
    precision, as an export with ``--precision float`` does. The memory stays an array of doubles, which are
    copied at each call.
    """
    lengths: dict[str, tuple[int, ...]] | None = None
    if single is not None:
        lengths = {name: (single[0], WRITTEN.get(name, 0)) for name in ENTRIES} | {"assimilate": single[1:]}
    library = native.library_of(text, ENTRIES, place, single=lengths)
    return native.ModuleC(library, ENTRIES, results={"least_force": ctypes.c_double})
