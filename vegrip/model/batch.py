"""Whole recordings through a generated module in one call, by C, numba or plain Python alike."""

import ctypes
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from vegrip.c99 import MEMORY, UntranslatableError
from vegrip.c99.host import CompilerError
from vegrip.c99.kinds import INT
from vegrip.contact import limit_surface
from vegrip.effects import Effect
from vegrip.effects.contract import GEOMETRY, OUTSIDE
from vegrip.model import cache, native, writer
from vegrip.model.composer import compose
from vegrip.types import Floats

ENTRIES: Final[native.Entries] = {
    "run": (*[MEMORY] * 6, INT),
    "channels": (*[MEMORY] * 10, INT),
    "depths": (*[MEMORY] * 9, INT),
}
"""The arrays, room for one step, and the number of rows."""


class Batch:
    """The entries that run a recording; see ``simulate_kernel.py`` and ``channels_kernel.py``.

    Arrays are given in their shapes; the kernels take them flat, so that one text serves C too.

    Args:
        effects: of the model.
        plain: run as uncompiled Python (70 times slower), to step through with a debugger.

    """

    def __init__(self, effects: tuple[Effect, ...], *, plain: bool) -> None:
        text = text_of(effects)
        states = sum(len(effect.states) for effect in effects)
        values = sum(len(effect.parameters) for effect in effects)
        self._room = values + len(GEOMETRY) + len(OUTSIDE) + 2 * states
        self._is_native = False
        mode = "python" if plain else native.kernel_mode()
        self._entries: dict[str, Callable[..., None]] = {}
        if mode.startswith("c"):
            self._take_native(text)
        if not self._is_native:
            module = cache.load_plain(text) if mode == "python" else cache.load(text)
            self._entries = {name: getattr(module, name) for name in ENTRIES}

    def run(self, values: Floats, states: Floats, t: Floats, inputs: Floats, out: Floats) -> None:
        """Fill ``out`` (n, 7) for ``inputs`` (n, 2 + outside) at ``t``; ``states`` ends as the last ones."""
        self._call("run", values, states, t, inputs, out)

    def channels(self, values: Floats, fresh: Floats, t: Floats, *arrays: Floats) -> None:
        self._call("channels", values, fresh, t, *arrays)

    def depths(self, values: Floats, fresh: Floats, t: Floats, *arrays: Floats) -> None:
        """Put indentations in place of the NaN of the motion."""
        self._call("depths", values, fresh, t, *arrays)

    def _call(self, name: str, *arrays: Floats) -> None:
        given = [*arrays, np.zeros(self._room)]
        for array in given:
            if array.dtype != np.float64 or not array.flags.c_contiguous:
                raise TypeError("arrays of a recording are of doubles, without gaps")
        taken: list[Any] = [a.ctypes.data if self._is_native else a.reshape(-1) for a in given]
        self._entries[name](*taken, arrays[2].size)

    def _take_native(self, text: str) -> None:
        try:
            path = native.library_of(text, ENTRIES)
        except (CompilerError, UntranslatableError) as error:
            native.tell_once(str(error))
            return
        library = ctypes.CDLL(str(path))  # lets other threads run: a recording takes longer than a switch
        for name, kinds in ENTRIES.items():
            entry = self._entries[name] = library[f"vg_{name}"]
            entry.argtypes = [ctypes.c_void_p if kind == MEMORY else ctypes.c_int32 for kind in kinds]
            entry.restype = None
        self._is_native = True


@lru_cache(maxsize=64)
def batch_of(effects: tuple[Effect, ...], mode: str, *, plain: bool = False) -> Batch:
    """Return the entries for ``effects``; they do not depend on the values of the parameters."""
    del mode  # the kernel mode, so that another one is another entry of the cache
    return Batch(effects, plain=plain)


def text_of(effects: tuple[Effect, ...]) -> str:
    here = Path(__file__)
    files = [Path(limit_surface.__file__).with_name("fast.py")]
    files += [here.with_name(f"{name}_kernel.py") for name in ("simulate", "channels")]
    kernels = [path.read_text(encoding="utf-8") for path in files]
    return writer.write(compose(effects), [effect.name for effect in effects], kernels, list(ENTRIES))
