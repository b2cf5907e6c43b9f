"""Files that are whole or not there: written beside their place, then renamed into it; and their refusals."""

import contextlib
import os
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from vegrip.errors import InputError, is_missing_from_installation


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a path beside ``path`` to write to; what is there at the end takes the place of ``path``.

    If that fails, on a full disk for instance, what was at ``path`` stays and nothing is left beside it. The
    permissions of a file that is replaced stay, and so does a link to it.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():  # a pipe, /dev/stdout: there is nothing to rename
        yield target
        return
    part = target.with_name(f".{secrets.token_hex(4)}-{target.name}")  # the end of the name is the format
    try:
        yield part
        if target.exists():
            shutil.copymode(target, part)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


@contextlib.contextmanager
def or_as_before(*paths: Path) -> Iterator[None]:
    """Put back what was at ``paths`` where what is done to them fails, and take away what was not there."""
    before = [path.read_bytes() if path.is_file() else None for path in paths]
    try:
        yield
    except BaseException:
        for path, content in zip(paths, before, strict=True):
            if content is None:
                path.unlink(missing_ok=True)
            elif path.read_bytes() != content:
                write_whole(path, content)
        raise


@contextlib.contextmanager
def filled_folder(folder: Path) -> Iterator[None]:
    """Make ``folder``; at the end it is gone again where nothing could be written to it."""
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            folder.rmdir()


@contextlib.contextmanager
def reading(path: Path, kind: type[InputError] = InputError) -> Iterator[None]:
    """Raise ``kind`` with one sentence where the system does not let ``path`` be read."""
    try:
        yield
    except FileNotFoundError:
        raise kind(f"{path}: there is no such file") from None
    except OSError as error:
        raise kind(f"{path}: cannot be read ({error.strerror or error})") from None


@contextlib.contextmanager
def writing(path: Path, kind: type[InputError] = InputError) -> Iterator[None]:
    """Raise ``kind`` with one sentence where the system does not let ``path`` be written."""
    try:
        yield
    except OSError as error:
        if is_missing_from_installation(error):
            raise
        raise kind(f"{path}: cannot be written ({error.strerror or error})") from None


def write_whole(path: Path, content: str | bytes) -> None:
    with whole_file(path) as part:
        part.write_bytes(content if isinstance(content, bytes) else content.encode())
