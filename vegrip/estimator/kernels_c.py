"""The estimator's kernels compiled by the C compiler of this machine, in place of numba's."""

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from vegrip.c99 import LONGS, MEMORY, REAL, host
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
KEPT: Final = 512  # addresses of arrays


class KernelsC:
    """The entries of a generated module, run by C.

    Args:
        library: the shared library.

    """

    def __init__(self, library: Path) -> None:
        self._loaded = host.load(library)
        self.update = self._called("update")
        self.filter_step = self._called("filter_step")
        self.margin_of = self._called("margin_of")
        self.least_force = self._called("least_force", ctypes.c_double)
        self.look_at_cells = self._called("look_at_cells")

    def entry(self, name: str, result: type[ctypes.c_double] | None = None) -> "ctypes._NamedFuncPointer":
        """Return a function of the library, which takes arrays by their addresses."""
        function = self._loaded[f"vg_{name}"]
        function.argtypes = [ctypes.c_double if kind == REAL else ctypes.c_void_p for kind in ENTRIES[name]]
        function.restype = result
        return function

    def _called(self, name: str, result: type[ctypes.c_double] | None = None) -> Callable[..., Any]:
        """Return an entry that takes arrays."""
        function, places = (
            self.entry(name, result),
            [i for i, kind in enumerate(ENTRIES[name]) if kind == MEMORY],
        )

        def call(*given: Any) -> Any:
            arguments = list(given)
            for i in places:
                arguments[i] = address(given[i])
            return function(*arguments)

        return call


_known: dict[int, tuple[Any, int]] = {}


def address(array: Any) -> int:
    """Return where an array lies; asking numpy costs a tenth of a step."""
    found = _known.get(id(array))
    if found is not None and found[0] is array:
        return found[1]
    if array.dtype.itemsize not in (1, 8) or not array.flags.c_contiguous or not array.flags.writeable:
        raise TypeError("an array of doubles without gaps that can be written to is needed")
    if len(_known) >= KEPT:
        _known.clear()
    _known[id(array)] = (array, array.ctypes.data)
    return _known[id(array)][1]


def load(text: str, place: Place = unknown_place, *, single: tuple[int, int] | None = None) -> KernelsC:
    """Return the kernels of a generated module's ``text``, from the cache or compiled now.

    With ``single``, the lengths of the filter's memory and of the whole one, they compute in single
    precision, as an export with
    ``--precision float`` does. The memory stays an array of doubles, which are copied at each call.

    Raises:
        CompilerError: there is no compiler, or it failed.
        UntranslatableError: a line cannot be translated; names file and line.

    """
    lengths: dict[str, tuple[int, ...]] | None = None
    if single is not None:
        lengths = {name: (single[0], WRITTEN.get(name, 0)) for name in ENTRIES} | {"assimilate": single[1:]}
    return KernelsC(native.library_of(text, ENTRIES, place, single=lengths))
