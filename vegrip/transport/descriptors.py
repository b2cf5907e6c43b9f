"""How many files this process may have open: libzmq aborts the process when it runs out of them."""

import os
import resource
from pathlib import Path
from typing import Final

from vegrip.errors import DeviceError

LEAST: Final = 512
"""Open files that a node must be allowed; it uses some fifty, the rest is for those who connect to it."""

ENOUGH: Final = 65_536

_OPEN: Final = Path("/proc/self/fd")


def raise_limit() -> None:
    """Allow this process ``ENOUGH`` open files, or as many as the system lets it have.

    Raises:
        DeviceError: that is too few to be safe from those who connect.

    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    reach = ENOUGH if hard == resource.RLIM_INFINITY else min(hard, ENOUGH)
    if soft != resource.RLIM_INFINITY and soft < reach:
        resource.setrlimit(resource.RLIMIT_NOFILE, (reach, hard))
    if limit() < LEAST:
        raise DeviceError(
            f"only {limit()} files may be open at once, and a node needs {LEAST}: else programs that connect "
            f"to it could end it; allow more (`ulimit -n {LEAST}`, or LimitNOFILE in a unit of systemd)"
        )


def limit() -> int:
    """Return how many files may be open."""
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return ENOUGH if soft == resource.RLIM_INFINITY else soft


def free() -> int:
    """Return how many more files may be opened; where the system does not tell, as many as ever."""
    try:
        return limit() - len(os.listdir(_OPEN))  # noqa: PTH208 (ten times faster)
    except FileNotFoundError:
        return limit()
    except OSError:  # to look takes one, too
        return 0
