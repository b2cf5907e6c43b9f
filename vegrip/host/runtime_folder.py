"""The folder of sockets that belong to one user: private, on this machine, gone after a reboot."""

import os
from pathlib import Path

from vegrip.errors import DeviceError
from vegrip.host.private_folder import runtime_root, why_not_private

LONGEST_SOCKET = 107
"""Bytes of the longest path a Unix socket may have on Linux."""

ASIDE = "~"
"""Ends the name of a socket that accepts no connection for the moment."""


def runtime_folder(part: str = "") -> Path:
    """Return the folder (or its ``part``), made when absent, readable by this user only.

    It is ``$VEGRIP_RUNTIME_DIR``, else ``$XDG_RUNTIME_DIR/vegrip``, else ``/tmp/vegrip-<uid>``.

    Raises:
        DeviceError: it cannot be made, belongs to another user, or others can enter it.

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
