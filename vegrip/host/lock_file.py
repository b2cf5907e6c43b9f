"""Files that are locked while a process lives: the lock tells the living from the dead, however they died."""

import contextlib
import fcntl
import os
import time
from pathlib import Path

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
