"""Files that are whole or not there: written beside their place, then renamed into it."""

import contextlib
import os
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path


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
    part = target.with_name(f".{secrets.token_hex(4)}-{target.name}")  # the end of the name tells the format
    try:
        yield part
        if target.exists():
            shutil.copymode(target, part)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write ``content`` to ``path``, text in UTF-8 as it stands."""
    with whole_file(path) as part:
        part.write_bytes(content if isinstance(content, bytes) else content.encode())
