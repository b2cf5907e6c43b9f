"""The folder of what the C compiler has made, which is run unread: only this user may write to it."""

import atexit
import contextlib
import functools
import logging
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from vegrip.host.folders import ROOT, runtime_root, why_not_private, why_not_trusted


def compiler() -> str | None:
    """Return the path of the C compiler: ``CC`` of the environment, else cc, gcc or clang."""
    for name in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        if name and (found := shutil.which(name)):
            return found
    return None


log = logging.getLogger(__name__)


class UntrustedError(Exception):
    """A folder in which others may have put code."""


def folder() -> Path:
    """Return where compiled code lives: ``VEGRIP_CACHE``, else the user's cache folder."""
    if own := os.environ.get("VEGRIP_CACHE"):
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vegrip"


def library(name: str, make: Callable[[Path], None]) -> Path:
    """Return the shared library ``name``; ``make`` compiles it to a path where it is not there.

    Raises what ``make`` raises.
    """
    where = folder()
    try:
        return _made(where, name, make)
    except (OSError, UntrustedError) as error:
        warn_not_kept(where, error)
    return _made(substitute(), name, make)


def found_library(name: str) -> Path | None:
    """Return the shared library ``name`` where :func:`library` has left it; None: it is not there."""
    for where in (folder(), _shared()):
        path = where / f"{name}.so"
        with contextlib.suppress(OSError, UntrustedError):
            if path.exists():
                check(where, name)
                return path
    return None


def check(where: Path, name: str) -> None:
    """Raise unless ``where``, and what lies there of the module ``name``, is this user's or root's."""
    if reason := why_not_trusted(where):
        raise UntrustedError(reason)
    compiled = where / "__pycache__"
    found = [compiled, *compiled.glob(f"{name}*"), where / f"{name}.py", where / f"{name}.so"]
    for place in (place for place in found if place.exists() or place.is_symlink()):
        if place.is_symlink() or place.stat().st_uid not in (os.getuid(), ROOT):
            raise UntrustedError(f"{place} belongs to another user or is a link")
    if compiled.exists() and compiled.stat().st_mode & 0o022:
        raise UntrustedError(f"{compiled} can be written by other users")


def warn_not_kept(where: Path, error: OSError | UntrustedError) -> None:
    _warn_once(where, error.strerror or str(error) if isinstance(error, OSError) else str(error))


@functools.cache
def _warn_once(where: Path, reason: str) -> None:
    log.warning("compiled models are not kept in %s: %s; correct that or set VEGRIP_CACHE", where, reason)


@functools.cache
def substitute() -> Path:
    """Return a private folder for as long as this user is logged in, or at least as this process lives."""
    where = _shared()
    with contextlib.suppress(OSError):
        where.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not why_not_private(where.parent):
            where.mkdir(mode=0o700, exist_ok=True)
            return where
    own = tempfile.mkdtemp(prefix="vegrip-")
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return Path(own)


def _shared() -> Path:
    return runtime_root() / "models"


def _made(where: Path, name: str, make: Callable[[Path], None]) -> Path:
    path = where / f"{name}.so"
    where.mkdir(mode=0o700, parents=True, exist_ok=True)
    check(where, name)
    if not path.exists():
        with tempfile.TemporaryDirectory(dir=where) as scratch:  # a reader never sees half a file
            make(Path(scratch) / path.name)
            (Path(scratch) / path.name).replace(path)
    return path
