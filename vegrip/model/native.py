"""What runs a generated text: C, numba or plain Python, and the library that a C compiler makes of it.

``VEGRIP_KERNEL`` says which: ``c``, the C compiler of this machine; ``numba``; ``python``, uncompiled. When
it is not set, C where there is a compiler (a second or two at a first start), else numba (half a minute). The
text is the same, translated statement by statement (:mod:`vegrip.c99`), and so is every number. ``c-float``
is C in single precision, as firmware may run it, to see what that costs; a node does not take it.
"""

import ctypes
import functools
import hashlib
import logging
import os
import platform
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from vegrip import c99
from vegrip.c99 import LONG, REAL, UntranslatableError, host, translate
from vegrip.c99.bridge import Lengths, behind_doubles
from vegrip.c99.kinds import DOUBLE, FLOAT, Kind
from vegrip.c99.names import Place, unknown_place
from vegrip.compiling import announce_compiling
from vegrip.errors import UsageError
from vegrip.host import compiled_folder
from vegrip.model import cache

MODES: Final = ("numba", "c", "c-float", "python")
SENTENCE: Final = (
    "compiles for this machine by its C compiler, once; later starts take it from the cache (about 3 s)"
)
Entries = Mapping[str, tuple[Kind, ...]]
"""What is called from outside, with the kinds of its arguments."""

libraries: dict[tuple[str, str, str], Path] = {}
log = logging.getLogger(__name__)


def kernel_mode() -> str:
    """Return what ``VEGRIP_KERNEL`` asks for; by default C where there is a compiler, else numba."""
    mode = os.environ.get("VEGRIP_KERNEL")
    if mode and mode not in MODES:
        raise UsageError(f"VEGRIP_KERNEL is {mode!r}; it is one of {', '.join(MODES)}")
    return mode or ("c" if host.compiler() is not None else "numba")


@functools.cache
def log_once(reason: str) -> None:
    log.warning(
        "VEGRIP_KERNEL=c is not possible: %s; numba is used, which compiles for half a minute", reason
    )


def run_by(
    mode: str,
    text: str,
    entries: Entries,
    place: Place = unknown_place,
    more: str = "",
    *,
    single: Lengths | None = None,
    results: Mapping[str, Any] | None = None,
    usual: Any = None,
) -> Any:
    """Return the module of a ``text`` as ``mode`` runs it, a :class:`ModuleC` where C does.

    Where C cannot be had, numba runs it, and the reason is logged once; the other arguments are those of
    :func:`library_of` and :class:`ModuleC`, ``single`` for ``c-float`` alone.
    """
    library = library_by(mode, text, entries, place, more, single=single if mode == "c-float" else None)
    if library is not None:
        return ModuleC(library, entries, usual, results)
    return cache.load_plain(text) if mode == "python" else cache.load(text)


def library_by(
    mode: str, text: str, entries: Entries, *more: Any, single: Lengths | None = None
) -> Path | None:
    """Return the library of :func:`library_of` if ``mode`` is C and it can be had."""
    if not mode.startswith("c"):
        return None
    try:
        return library_of(text, entries, *more, single=single)
    except (host.CompilerError, UntranslatableError) as error:
        log_once(str(error))
        return None


def library_of(
    text: str,
    entries: Entries,
    place: Place = unknown_place,
    more: str = "",
    *,
    single: Lengths | None = None,
) -> Path:
    """Return the library with the ``entries`` of a ``text``, from the cache or compiled now.

    ``more`` is C that stands below, for what calls the entries in turn. With ``single``, the lengths of the
    memories of each entry, it computes in single precision behind functions of doubles.
    """
    key = (text, more, repr(single))
    if key not in libraries:
        libraries[key] = _library(text, entries, place, more, single=single)
    return libraries[key]


def _library(text: str, entries: Entries, place: Place, more: str, *, single: Lengths | None) -> Path:
    compiler = host.compiler()
    if compiler is None:
        raise host.CompilerError("there is no C compiler (cc, gcc or clang)")

    def make(library: Path) -> None:
        announce_compiling(SENTENCE)
        c = translate(text, entries, place=place, reals=DOUBLE if single is None else FLOAT).text()
        if single is not None:
            c = behind_doubles(c, entries, single)
        host.build(f"{c}\n{more}", library)

    return compiled_folder.library(_name(f"{single or 0} {text}{more}", compiler), make)


def _name(text: str, compiler: str) -> str:
    tool = os.stat(compiler)  # noqa: PTH116 (followed to the end of its links)
    parts = [text, platform.machine(), compiler, str(tool.st_size), str(tool.st_mtime_ns), *host.FLAGS]
    parts += _translator()
    return "vegrip_c_" + hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]


@functools.cache
def _translator() -> tuple[str, ...]:
    """Return the texts of the translator; a diagnosis asks for dozens of libraries."""
    folder = Path(c99.__file__).parent
    return tuple(path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.py")))


KEPT: Final = 512  # addresses of arrays
_known: dict[int, tuple[Any, int]] = {}
_VALUES: Final[Mapping[Kind, Any]] = {REAL: ctypes.c_double, LONG: ctypes.c_int64}


class ModuleC:
    """A generated module run by C: its entries by their names, which take arrays.

    Args:
        library: the shared library.
        entries: of it.
        results: kinds of C of what they return, by name; of all others ``usual``.

    """

    def __init__(
        self, library: Path, entries: Entries, usual: Any = None, results: Mapping[str, Any] | None = None
    ) -> None:
        self.library, self.loaded = library, host.load(library)
        self._entries, self._usual, self._results = entries, usual, results or {}

    def entry(self, name: str) -> Any:
        """Return a function of the library, which takes arrays by their addresses."""
        function = self.loaded[f"vg_{name}"]
        function.argtypes = [_VALUES.get(kind, ctypes.c_void_p) for kind in self._entries[name]]
        function.restype = self._results.get(name, self._usual)
        return function

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name.startswith("_") or name not in self._entries:
            raise AttributeError(name)
        function = self.entry(name)
        places = [i for i, kind in enumerate(self._entries[name]) if kind not in _VALUES]

        def call(*given: Any) -> Any:
            arguments = list(given)
            for i in places:
                arguments[i] = address(given[i])
            return function(*arguments)

        setattr(self, name, call)
        return call


def bound_call(module: Any, name: str, *arrays: Any) -> Callable[..., int]:
    """Return an entry of ``module`` on arrays that stay where they are and are kept by the caller."""
    if isinstance(module, ModuleC):
        return functools.partial(module.entry(name), *map(address, arrays))
    return functools.partial(getattr(module, name), *arrays)


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
