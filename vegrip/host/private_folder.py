"""Whether a folder is this user's own: what others could change there must not be believed, let alone run."""

import os
import stat
from pathlib import Path

ROOT = 0  # the user whose folders every user has to trust


def runtime_root() -> Path:
    """Return the folder for what this user's processes share while they run, which need not exist.

    It is ``$VEGRIP_RUNTIME_DIR``, else ``$XDG_RUNTIME_DIR/vegrip``, else ``/tmp/vegrip-<uid>``.
    """
    if chosen := os.environ.get("VEGRIP_RUNTIME_DIR"):
        return Path(chosen)
    if session := os.environ.get("XDG_RUNTIME_DIR"):
        return Path(session) / "vegrip"
    return Path(f"/tmp/vegrip-{os.getuid()}")  # noqa: S108 (who owns it, and who may enter, is checked)


def why_not_private(path: Path) -> str:
    """Return why others could see or change what is in the folder ``path``; empty when they cannot.

    A symbolic link counts only when this user has made it: another's could lead elsewhere tomorrow.
    """
    link = path.lstat()
    if stat.S_ISLNK(link.st_mode) and link.st_uid != os.getuid():
        return "is a symbolic link that another user has made"
    found = path.stat()
    if not stat.S_ISDIR(found.st_mode):
        return "is not a folder"
    if found.st_uid != os.getuid():
        return "belongs to another user"
    return "can be entered by other users" if stat.S_IMODE(found.st_mode) & 0o077 else ""


def why_not_trusted(path: Path) -> str:
    """Return why code in the folder ``path`` may be another's; empty when only this user or root writes it.

    Neither the folder nor any above it may be writable by others, but for one with the sticky bit, such as
    ``/tmp``, in which they cannot rename what is not theirs.
    """
    for place in (path, *path.parents):
        if place.is_symlink() and place.lstat().st_uid not in (os.getuid(), ROOT):
            return f"{place} is a symbolic link that another user has made"
    inner = path.resolve()
    for place in (inner, *inner.parents):
        found = place.stat()
        if found.st_uid not in (os.getuid(), ROOT):
            return f"{place} belongs to another user"
        if found.st_mode & 0o022 and not (place != inner and found.st_mode & stat.S_ISVTX):
            return f"{place} can be written by other users"
    return ""
