"""What this user may do: real-time priority, locked memory, the folder of sockets, the compiler's cache."""

import os
import tempfile
from pathlib import Path

from vegrip.errors import DeviceError
from vegrip.host import realtime
from vegrip.host.folders import runtime_folder
from vegrip.host.realtime import Permission
from vegrip.runtime.doctor.finding import Finding, fail, ok, warn


def priority(allowed: Permission | None = None) -> Finding:
    """Whether nodes, hand and virtual bus get the real-time priority and the locked memory they ask for."""
    if not realtime.is_switched_on():
        text, remedy = f"real-time priority is switched off: {realtime.SWITCH}", f"unset {realtime.SWITCH}"
        return warn("priority", text, remedy)
    allowed = allowed or realtime.permission()
    chosen = realtime.choose_scheduling(realtime.HUB_PRIORITY, allowed, on=True)
    if not chosen.priority:
        text = f"real-time priority is allowed up to {allowed.highest}, and {realtime.HUB_PRIORITY} is needed"
        return warn("priority", text, realtime.remedy())
    if not chosen.lock_memory:
        text = "nodes, hand and virtual bus get real-time priority, and no locked memory"
        return warn("priority", text, realtime.remedy())
    return ok("priority", "nodes, hand and virtual bus get real-time priority and locked memory")


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
