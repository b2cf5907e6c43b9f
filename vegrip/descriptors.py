"""How many files and sockets this process may have open; too few are refused before a library aborts."""

import contextlib
import errno
import resource

from vegrip.errors import DeviceError

LEAST = 32
"""A node with its bus, telemetry and control takes some twenty; out of them libzmq ends the process."""

WANTED = 4096


def require_descriptors() -> None:
    """Ask for enough descriptors, as far as this user may have them.

    Raises:
        DeviceError: there are too few even so.

    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != resource.RLIM_INFINITY and soft < WANTED:
        soft = WANTED if hard == resource.RLIM_INFINITY else min(WANTED, hard)
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    allowed = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if allowed != resource.RLIM_INFINITY and allowed < LEAST:
        raise DeviceError(
            f"only {allowed} files may be open at once, {LEAST} are needed; raise it with `ulimit -n 1024`"
        )


def is_out_of_descriptors(error: BaseException) -> bool:
    """Whether ``error`` (of the system or of ZeroMQ) says that no more files can be opened."""
    return getattr(error, "errno", None) in (errno.EMFILE, errno.ENFILE)
