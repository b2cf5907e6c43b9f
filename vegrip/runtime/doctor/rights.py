"""What this user may do: real-time priority, locked memory, the folder of sockets, the compiler's cache."""

import os
import resource
import tempfile
from pathlib import Path

from vegrip.errors import DeviceError
from vegrip.host.runtime_folder import runtime_folder
from vegrip.runtime.doctor.finding import Finding, fail, ok, warn

LIMITS = "/etc/security/limits.d/vegrip.conf"


def priority(limit: int | None = None) -> Finding:
    """Whether real-time priority may be asked for (`chrt -f 50 vegrip node ...`)."""
    allowed = resource.getrlimit(resource.RLIMIT_RTPRIO)[0] if limit is None else limit
    if os.geteuid() == 0 or allowed == resource.RLIM_INFINITY or allowed >= 50:
        return ok("priority", "real-time priority is allowed: chrt -f 50 vegrip node grasp_force")
    remedy = f"echo '{_user()} - rtprio 50' | sudo tee {LIMITS}, and log in again"
    return warn("priority", f"real-time priority is allowed up to {allowed}", remedy)


def sockets() -> Finding:
    """The private folder in which the nodes of this user find each other."""
    try:
        folder = runtime_folder()
    except DeviceError as error:
        return fail("sockets", str(error), "set VEGRIP_RUNTIME_DIR to a private folder")
    return ok("sockets", str(folder))


def compiler_cache(folder: Path | None = None) -> Finding:
    """Where numba keeps compiled code; without it every start compiles for a minute."""
    folder = folder or cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        remedy = "set NUMBA_CACHE_DIR to a folder that can be written"
        return fail("compiler cache", f"{folder} cannot be written ({error.strerror or error})", remedy)
    count = sum(1 for _ in folder.rglob("*.nbc"))
    text = f"{count} compiled functions in {folder}"
    if not count:
        return warn("compiler cache", text, "nothing: the first start of a node compiles, later ones do not")
    return ok("compiler cache", text)


def cache_folder() -> Path:
    """Return the folder of compiled code: ``$NUMBA_CACHE_DIR``, else beside the package."""
    import vegrip  # noqa: PLC0415 (only its place is wanted)

    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return Path(chosen) if chosen else Path(next(iter(vegrip.__path__)))


def _user() -> str:
    return os.environ.get("USER", "") or str(os.getuid())
