"""What a command writes beside its answer: checked before the work, and never at the cost of the answer.

What is there already is refused unless ``--force`` is given. What cannot be written is one sentence on
standard error, before the work where it can be known; the answer is printed all the same and the exit code
is 3 when it was known before, 4 when it was lost afterwards.
"""

import contextlib
import importlib.util
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Annotated, Self

import typer

from vegrip.cli._terminal import complain
from vegrip.errors import InputError, UsageError

FORCE = Annotated[bool, typer.Option("--force", help="Replace what is there already.")]

FORMATS = (".png", ".pdf", ".svg", ".jpg", ".webp")
KNOWN_BEFORE = InputError.exit_code
LOST_AFTERWARDS = 4
TAKEN = "is there already; give another name, or --force to replace it"


class Outputs:
    """The files and folders of one call; used with ``with``, which ends the command with the exit code."""

    def __init__(self, *, force: bool) -> None:
        self._force = force
        self._made: list[Path] = []  # folders, outermost first
        self._unwritable: set[Path] = set()
        self._code = 0

    def file(self, path: Path | None) -> None:
        """Announce a file."""
        if path is not None:
            _refuse_file(path, force=self._force)
            self._try(path, path.parent)

    def folder(self, path: Path | None) -> None:
        """Announce a folder of files that are made here."""
        if path is not None:
            _refuse_folder(path, force=self._force)
            self._try(path, path)

    def log(self, path: Path | None) -> None:
        """Announce a file that grows: what is in it stays, unless ``--force`` is given."""
        if path is None:
            return
        _refuse_file(path, force=True)
        self._try(path, path.parent)
        if self._force:
            self.write(path, lambda old: old.unlink(missing_ok=True))

    def picture(self, path: Path | None) -> None:
        """Announce a picture."""
        if path is not None:
            require_matplotlib()
            if path.suffix.lower() not in FORMATS:
                raise InputError(
                    f"{path}: the picture cannot be written; end its name in {', '.join(FORMATS)}"
                )
        self.file(path)

    def pictures(self, path: Path | None) -> None:
        """Announce a folder of pictures; raises as :meth:`picture`."""
        if path is not None:
            require_matplotlib()
        self.folder(path)

    def write(self, path: Path | None, writer: Callable[[Path], object]) -> bool:
        """Write what was announced; say so in a sentence if that fails, and return whether it was written."""
        if path is None or path in self._unwritable:
            return False
        try:
            writer(path)
        except (OSError, InputError) as error:
            reason = error.strerror or error if isinstance(error, OSError) else error
            complain(f"{path}: is not written ({reason})")
            self._unwritable.add(path)
            self._code = LOST_AFTERWARDS
            return False
        return True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for folder in reversed(self._made):  # what stayed empty
            with contextlib.suppress(OSError):
                folder.rmdir()
        if error is None and self._code:
            raise typer.Exit(self._code)

    def _try(self, path: Path, folder: Path) -> None:
        try:
            for each in reversed([folder, *folder.parents]):
                if not each.exists():
                    each.mkdir()
                    self._made.append(each)
            with tempfile.TemporaryFile(dir=folder):
                pass
            if path.is_file() and not os.access(path, os.W_OK):
                raise PermissionError(13, os.strerror(13))
        except OSError as error:
            complain(f"{path}: cannot be written ({error.strerror or error}); the result is only printed")
            self._unwritable.add(path)
            self._code = KNOWN_BEFORE


def _refuse_file(path: Path, *, force: bool) -> None:
    if path.is_dir():
        raise UsageError(f"{path}: is a folder; give the name of a file")
    if path.exists() and not force:
        raise InputError(f"{path}: {TAKEN}")


def _refuse_folder(path: Path, *, force: bool) -> None:
    if path.is_file():
        raise UsageError(f"{path}: is a file; give the name of a folder")
    if path.is_dir() and any(path.iterdir()) and not force:
        raise InputError(f"{path}: {TAKEN}")


def claim_file(path: Path, *, force: bool) -> None:
    _refuse_file(path, force=force)
    require_writable(path.parent)


def claim_folder(path: Path, *, force: bool) -> None:
    _refuse_folder(path, force=force)
    require_writable(path)


def require_matplotlib() -> None:
    if importlib.util.find_spec("matplotlib") is None:
        raise UsageError("pictures need matplotlib; pip install 'vegrip[plot]'")


def claim_recording(folder: Path, *, force: bool) -> None:
    """Refuse to write a recording to ``folder`` where one is, and where none can be."""
    from vegrip.identification.recording.session import holds_recording

    if folder.is_file():
        raise UsageError(f"{folder}: is a file; a recording is a folder")
    if holds_recording(folder) and not force:
        raise InputError(f"{folder}: holds a recording already; give another name, or --force to replace it")
    require_writable(folder)


def require_writable(folder: Path) -> None:
    """Refuse a folder that can neither be made nor written."""
    is_there = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    try:
        with tempfile.TemporaryFile(dir=is_there):
            pass
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror or error})") from None
