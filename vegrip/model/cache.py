"""Generated modules on disk, named by the hash of their content, and their import.

numba's cache trusts the file that holds a function and nothing else, so one model is one flat file and its
name changes with every change of text or of numba; stale physics cannot run. Beside the file lies what was
compiled from it, which is run unread: a folder that others can write is not used.
"""

import hashlib
import importlib.util
import sys
import threading
from pathlib import Path
from types import ModuleType

from vegrip.compiled import GENERATED, announcer, load_numba
from vegrip.host import compiled_folder
from vegrip.host.compiled_folder import UntrustedError
from vegrip.whole_file import write_whole

LOADING = threading.RLock()
"""Held while a module is imported: another thread must not take it half executed."""


def load(text: str) -> ModuleType:
    """Return the compiled module of ``text``; functions compile when first called, or come from the cache.

    When they compile, :func:`vegrip.compiling.announce_compiling` says so.
    """
    name = GENERATED + hashlib.sha256(f"{load_numba().__version__}\n{text}".encode()).hexdigest()[:24]
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
