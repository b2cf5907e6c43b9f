"""Sockets and locks that one user's processes share, in a private folder that is gone after a reboot.

What others could change there must not be trusted, let alone run. A file that is locked while a process
lives distinguishes the living from the dead, however they died; what killed processes have left is removed.
"""

import contextlib
import errno
import fcntl
import os
import socket
import stat
import time
from pathlib import Path

from vegrip.errors import DeviceError

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


LONGEST_SOCKET = 107
"""Bytes of the longest path a Unix socket may have on Linux."""

ASIDE = "~"
"""Ends the name of a socket that accepts no connection for the moment."""


def runtime_folder(part: str = "") -> Path:
    """Return the folder (or its ``part``), made when absent, readable by this user only.

    It is ``$VEGRIP_RUNTIME_DIR``, else ``$XDG_RUNTIME_DIR/vegrip``, else ``/tmp/vegrip-<uid>``.
    """
    root = runtime_root()
    try:
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
        if reason := why_not_private(root):
            raise DeviceError(f"{root} {reason}; remove it or set VEGRIP_RUNTIME_DIR to a private folder")
        (root / part).mkdir(mode=0o700, exist_ok=True)
    except OSError as error:
        raise DeviceError(
            f"the folder {root / part} cannot be made ({error}); set VEGRIP_RUNTIME_DIR"
        ) from None
    return root / part


def socket_path(part: str, name: str) -> Path:
    path = runtime_folder(part) / name
    if len(os.fsencode(path)) > LONGEST_SOCKET:
        raise DeviceError(
            f"{path} is too long for a socket (at most {LONGEST_SOCKET} bytes); "
            "use a shorter name or set VEGRIP_RUNTIME_DIR to a shorter folder"
        )
    return path


ATTEMPTS = 10


def locked(path: Path) -> int | None:
    """Open and lock ``path``, made when absent; return its descriptor, None when another process holds it.

    Trap: between the two steps another process, which looks for what the dead have left, may hold the lock
    briefly and remove the file.
    """
    for _ in range(ATTEMPTS):
        handle = os.open(path, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o600)
        with contextlib.suppress(BlockingIOError, FileNotFoundError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if path.stat().st_ino == os.fstat(handle).st_ino:
                return handle
        os.close(handle)
        time.sleep(0.005)
    return None


def remove_if_unlocked(path: Path) -> None:
    """Remove ``path`` if no process holds its lock."""
    try:
        handle = os.open(path, os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if path.stat().st_ino == os.fstat(handle).st_ino:
            path.unlink()
    except (BlockingIOError, FileNotFoundError):
        pass
    finally:
        os.close(handle)


SOCKETS = (("can", "*.bus"), ("nodes", "*.[ct]"), ("nodes", f"*.[ct]{ASIDE}"), ("zmq", "*"))
LOCKS = (("can", "*.lock"),)
MIN_SOCKET_AGE_S = 10.0
"""[s] A younger socket is not judged: between its making and its first listening nothing answers."""

SOCKET_KINDS = (socket.SOCK_STREAM, socket.SOCK_SEQPACKET)


def remove_leftovers(now: float | None = None) -> None:
    """Remove what the dead have left; ``now`` [s since 1970] is the time to judge ages by. Raises nothing."""
    now = time.time() if now is None else now
    with contextlib.suppress(OSError, DeviceError):
        served = _served()
        for part, pattern in SOCKETS:
            for path in runtime_folder(part).glob(pattern):
                if str(path).removesuffix(ASIDE) not in served and _is_dead(path, now):
                    path.unlink(missing_ok=True)
        for part, pattern in LOCKS:
            for path in runtime_folder(part).glob(pattern):
                remove_if_unlocked(path)


def _served() -> set[str]:
    """Return the paths of all sockets that are open on this machine, so that none of them need be tried."""
    try:
        lines = Path("/proc/net/unix").read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    except OSError:
        return set()
    return {fields[7] for line in lines if len(fields := line.split(maxsplit=7)) == 8}


def _is_dead(path: Path, now: float) -> bool:
    """Return whether nothing listens at ``path``; it is tried, for the owner may be in another namespace."""
    found = path.lstat()
    if not stat.S_ISSOCK(found.st_mode) or now - found.st_mtime < MIN_SOCKET_AGE_S:
        return False
    return all(_refuses(path, kind) for kind in SOCKET_KINDS)


def _refuses(path: Path, kind: int) -> bool:
    with socket.socket(socket.AF_UNIX, kind) as probe:
        probe.setblocking(False)
        try:
            probe.connect(str(path))
        except ConnectionRefusedError:
            return True
        except OSError as error:  # EPROTOTYPE: of the other kind, which says nothing of life
            return error.errno == errno.EPROTOTYPE
    return False
