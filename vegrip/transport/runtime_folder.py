"""The folder of sockets that belong to one user: private, on this machine, gone after a reboot."""

import os
import stat
from pathlib import Path

from vegrip.errors import DeviceError

LONGEST_SOCKET = 107
"""Bytes of the longest path a Unix socket may have on Linux."""


def runtime_folder(part: str = "") -> Path:
    """Return the folder (or its ``part``), made when absent, readable by this user only.

    It is ``$VEGRIP_RUNTIME_DIR``, else ``$XDG_RUNTIME_DIR/vegrip``, else ``/tmp/vegrip-<uid>``.

    Raises:
        DeviceError: it cannot be made, or belongs to somebody else.

    """
    folder = _root() / part
    try:
        _root().mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        root = _root().stat()
    except OSError as error:
        raise DeviceError(f"the folder {folder} cannot be made ({error}); set VEGRIP_RUNTIME_DIR") from None
    if root.st_uid != os.getuid() or stat.S_IMODE(root.st_mode) & 0o077:
        raise DeviceError(
            f"{_root()} can be entered by other users; "
            "remove it or set VEGRIP_RUNTIME_DIR to a private folder"
        )
    return folder


def socket_path(part: str, name: str) -> Path:
    """Return the path of a socket in the folder ``part``.

    Raises:
        DeviceError: the path is too long for a socket.

    """
    path = runtime_folder(part) / name
    if len(os.fsencode(path)) > LONGEST_SOCKET:
        raise DeviceError(
            f"{path} is too long for a socket (at most {LONGEST_SOCKET} bytes); "
            "use a shorter name or set VEGRIP_RUNTIME_DIR to a shorter folder"
        )
    return path


def _root() -> Path:
    if chosen := os.environ.get("VEGRIP_RUNTIME_DIR"):
        return Path(chosen)
    if session := os.environ.get("XDG_RUNTIME_DIR"):
        return Path(session) / "vegrip"
    return Path(f"/tmp/vegrip-{os.getuid()}")  # noqa: S108 (ownership and mode are checked)
