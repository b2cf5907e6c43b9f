"""What killed processes have left in the runtime folder: sockets without a server, locks without a holder."""

import contextlib
import errno
import socket
import stat
import time
from pathlib import Path

from vegrip.errors import DeviceError
from vegrip.host.lock_file import remove_if_unlocked
from vegrip.host.runtime_folder import ASIDE, runtime_folder

SOCKETS = (("can", "*.bus"), ("nodes", "*.[ct]"), ("nodes", f"*.[ct]{ASIDE}"), ("zmq", "*"))
LOCKS = (("can", "*.lock"),)
NEWEST = 10.0
"""[s] A younger socket is not judged: between its making and its first listening nothing answers."""

KINDS = (socket.SOCK_STREAM, socket.SOCK_SEQPACKET)


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
    """Tell whether nothing listens at ``path``; it is tried, for the owner may be in another namespace."""
    found = path.lstat()
    if not stat.S_ISSOCK(found.st_mode) or now - found.st_mtime < NEWEST:
        return False
    return all(_refuses(path, kind) for kind in KINDS)


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
