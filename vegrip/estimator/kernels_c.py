"""The estimator's kernels compiled by the C compiler of this machine, in place of numba's."""

import ctypes
from pathlib import Path
from typing import Final

import numpy as np

from vegrip.c99 import MEMORY, REAL, host
from vegrip.c99.refusal import Place, unknown_place
from vegrip.model import native
from vegrip.types import Floats

ENTRIES: Final[native.Entries] = {
    "update": (MEMORY, *[REAL] * 7),
    "filter_step": (MEMORY, *[REAL] * 4),
    "margin_of": (MEMORY, REAL, REAL, MEMORY),
    "least_force": (MEMORY, *[REAL] * 4),
    "look_at_cells": (MEMORY, REAL, MEMORY),
}
"""What is called from outside, with the kinds of its arguments."""
WRITTEN: Final = {"margin_of": 5, "look_at_cells": 6}
"""How many numbers an entry writes besides the memory."""
KEPT = 256  # addresses of memories


class KernelsC:
    """The entries of a generated module, run by C.

    Args:
        library: the shared library.

    """

    def __init__(self, library: Path) -> None:
        loaded = host.load(library)
        self._update = _entry(loaded, "update", None)
        self._filter_step = _entry(loaded, "filter_step", None)
        self._margin_of = _entry(loaded, "margin_of", None)
        self._least_force = _entry(loaded, "least_force", ctypes.c_double)
        self._look_at_cells = _entry(loaded, "look_at_cells", None)
        self._known: dict[int, tuple[Floats, int]] = {}

    def update(
        self,
        m: Floats,
        dt: float,
        force: float,
        displacement: float,
        radius: float,
        tangential: float,
        torque: float,
        slip: float,
    ) -> None:
        """As :func:`vegrip.estimator.kernels.update.update`."""
        self._update(self._address(m), dt, force, displacement, radius, tangential, torque, slip)

    def filter_step(self, m: Floats, dt: float, force: float, displacement: float, radius: float) -> None:
        """As :func:`vegrip.estimator.kernels.update.filter_step`."""
        self._filter_step(self._address(m), dt, force, displacement, radius)

    def margin_of(self, m: Floats, tangential: float, torque: float, out: Floats) -> None:
        """As :func:`vegrip.estimator.kernels.update.margin_of`."""
        self._margin_of(self._address(m), tangential, torque, self._address(out))

    def least_force(
        self, m: Floats, tangential: float, torque: float, margin: float, quantile: float
    ) -> float:
        """As :func:`vegrip.estimator.kernels.forecast.least_force`."""
        force: float = self._least_force(self._address(m), tangential, torque, margin, quantile)
        return force

    def look_at_cells(self, m: Floats, before: float, out: Floats) -> None:
        """As :func:`vegrip.estimator.kernels.health.look_at_cells`."""
        self._look_at_cells(self._address(m), before, self._address(out))

    def _address(self, m: Floats) -> int:
        """Return where the numbers of ``m`` lie; asking numpy costs a tenth of a step."""
        found = self._known.get(id(m))
        if found is not None and found[0] is m:
            return found[1]
        if m.dtype != np.float64 or not m.flags.c_contiguous or not m.flags.writeable:
            raise TypeError("the memory is one array of doubles, without gaps")
        if len(self._known) >= KEPT:
            self._known.clear()
        self._known[id(m)] = (m, m.ctypes.data)
        return m.ctypes.data


def _entry(
    library: ctypes.CDLL, name: str, result: type[ctypes.c_double] | None
) -> "ctypes._NamedFuncPointer":
    function = library[f"vg_{name}"]
    function.argtypes = [ctypes.c_void_p if kind == MEMORY else ctypes.c_double for kind in ENTRIES[name]]
    function.restype = result
    return function


def load(text: str, place: Place = unknown_place, *, single: int = 0) -> KernelsC:
    """Return the kernels of a generated module's ``text``, from the cache or compiled now.

    With ``single``, the length of the memory, they compute in single precision, as an export with
    ``--precision float`` does. The memory stays an array of doubles, which are copied at each call.

    Raises:
        CompilerError: there is no compiler, or it failed.
        UntranslatableError: a line cannot be translated; names file and line.

    """
    lengths = {name: (single, WRITTEN.get(name, 0)) for name in ENTRIES} if single else None
    return KernelsC(native.library_of(text, ENTRIES, place, single=lengths))
