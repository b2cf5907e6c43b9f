"""Generated modules on disk, named by the hash of their content, and their import.

numba's cache trusts the file that holds a function and nothing else, so one model is one flat file and its
name changes with every change of text or of numba; stale physics cannot run. Beside the file lies what was
compiled from it, which is run unread: a folder that others can write is not used.
"""

import hashlib
import importlib.util
import sys
import threading
import time
from pathlib import Path
from types import ModuleType

import numba
from numba.core import event

from vegrip.compiling import announce_compiling
from vegrip.host import compiled_folder
from vegrip.host.compiled_folder import UntrustedError
from vegrip.whole_file import write_whole

NEWS_PERIOD_S = 3.0  # [s] between two sentences of progress
GENERATED = "vegrip_generated_"
"""How the names of generated modules begin."""
LOADING = threading.RLock()
"""Held while a module is imported: another thread must not take it half executed."""


class _Announcer(event.Listener):
    """Says that numba is at work on a model, and how far it is: not for what comes from the cache."""

    said = False
    functions = 0
    """Of the generated modules that were loaded to be compiled; not all of them are called."""

    def __init__(self) -> None:
        self._compiled: set[tuple[str, str]] = set()
        self._since = self._told = 0.0  # [s]

    def on_start(self, event: event.Event) -> None:
        """Say it when a function of a generated module begins to compile."""
        module, name = _function_of(event)
        if not module:
            return
        now = time.monotonic()
        if not self.said:
            self.said, self._since, self._told = True, now, now
            announce_compiling()
        elif now - self._told >= NEWS_PERIOD_S:
            self._told = now
            announce_compiling(f"compiling {name}: {self._done()}, {now - self._since:.0f} s so far")

    def on_end(self, event: event.Event) -> None:
        if (function := _function_of(event))[0]:
            self._compiled.add(function)

    def _done(self) -> str:
        """Return how many functions are compiled, and of how many where that is known.

        How many a module of vegrip itself has is not: only what was generated was counted when it was loaded.
        """
        generated = sum(module.startswith(GENERATED) for module, _ in self._compiled)
        if generated < len(self._compiled) or generated >= self.functions:
            return f"{len(self._compiled)} compiled before it"
        return f"{generated} of at most {self.functions} functions are done"


def _function_of(event: event.Event) -> tuple[str, str]:
    function = getattr(event.data["dispatcher"], "py_func", None)
    module = getattr(function, "__module__", "") or ""
    return (module, str(getattr(function, "__name__", ""))) if module.startswith("vegrip") else ("", "")


announcer = _Announcer()
event.register("numba:compile", announcer)  # type: ignore[no-untyped-call]


def load(text: str) -> ModuleType:
    """Return the compiled module of ``text``; functions compile when first called, or come from the cache.

    When they compile, :func:`vegrip.compiling.announce_compiling` says so.
    """
    name = GENERATED + hashlib.sha256(f"{numba.__version__}\n{text}".encode()).hexdigest()[:24]
    with LOADING:
        if name not in sys.modules:
            announcer.functions += text.count("\ndef ")
            _import(name, _written(name, text))
        return sys.modules[name]


def load_plain(text: str) -> ModuleType:
    """Return the same module uncompiled, to step through it with a debugger.

    It computes as the compiled one does, see :mod:`vegrip.model.ieee_math`.
    """
    plain = text.replace("_ = numba.njit(", "_ = math.uncompiled(").replace("import numba\n", "")
    plain = plain.replace("import math\n", "from vegrip.model import ieee_math as math\n")
    name = "vegrip_plain_" + hashlib.sha256(plain.encode()).hexdigest()[:24]
    with LOADING:
        if name not in sys.modules:
            _import(name, _written(name, plain))
        return sys.modules[name]


def _written(name: str, text: str) -> Path:
    """Write the module unless it is there; a reader never sees half a file."""
    where = compiled_folder.folder()
    try:
        return _write(where, name, text)
    except (OSError, UntrustedError) as error:
        compiled_folder.warn_not_kept(where, error)
    return _write(compiled_folder.substitute(), name, text)


def _write(where: Path, name: str, text: str) -> Path:
    path = where / f"{name}.py"
    where.mkdir(mode=0o700, parents=True, exist_ok=True)
    compiled_folder.check(where, name)
    if path.exists() and path.read_text(encoding="utf-8") == text:
        return path
    write_whole(path, text)
    return path


def _import(name: str, path: Path) -> None:
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None  # noqa: S101, PT018
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
