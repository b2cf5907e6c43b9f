"""How many files this process may have open: libzmq aborts the process when it runs out of them."""

import contextlib
import errno
import os
import resource
from pathlib import Path
from typing import Final

from vegrip.errors import DeviceError

COMMAND_NEEDS: Final = 32
"""Open files that a command must be allowed."""

NODE_NEEDS: Final = 512
"""Open files that a node must be allowed; it uses some fifty, the rest is for those who connect to it."""

WANTED_DESCRIPTORS: Final = 65_536

_OPEN: Final = Path("/proc/self/fd")


def require_descriptors(least: int) -> None:
    """Allow this process ``WANTED_DESCRIPTORS`` open files, or as many as the system lets it have."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    reach = WANTED_DESCRIPTORS if hard == resource.RLIM_INFINITY else min(hard, WANTED_DESCRIPTORS)
    if soft != resource.RLIM_INFINITY and soft < reach:
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (reach, hard))
    if limit() < least:
        raise DeviceError(
            f"only {limit()} files may be open at once, and {least} are needed; allow more "
            f"(`ulimit -n {NODE_NEEDS}`, or LimitNOFILE in a unit of systemd)"
        )


def limit() -> int:
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return WANTED_DESCRIPTORS if soft == resource.RLIM_INFINITY else soft


def free() -> int:
    """Return how many more files may be opened; where the system does not say, as many as ever."""
    try:
        return limit() - len(os.listdir(_OPEN))  # noqa: PTH208 (ten times faster)
    except FileNotFoundError:
        return limit()
    except OSError:  # to look takes one, too
        return 0


def is_out_of_descriptors(error: BaseException) -> bool:
    return getattr(error, "errno", None) in (errno.EMFILE, errno.ENFILE)
