"""The bit rates that a SocketCAN interface is set to, whatever the configuration says. Asks ``ip``."""

import json
import shutil
import subprocess
from collections.abc import Callable

import can

IP_TIMEOUT_S = 5.0  # [s]
Ask = Callable[[str], str]


def check_rates(channel: str, bitrate: int, data_bitrate: int, *, fd: bool, ask: Ask | None = None) -> None:
    """Refuse an interface that is set to other bit rates; one without (vcan, or no ``ip`` here) passes.

    Raises:
        can.CanInitializationError: with the remedy.

    """
    nominal, fast = rates((ask or _ip)(channel))
    wrong = nominal not in (0, bitrate)
    wrong_data = fd and fast not in (0, data_bitrate)
    if wrong or wrong_data:
        data = f" dbitrate {data_bitrate} fd on" if fd else ""
        told = f"{nominal} and {fast}" if fd else f"{nominal}"
        asked = f"{bitrate} and {data_bitrate}" if fd else f"{bitrate}"
        raise can.CanInitializationError(
            f"it is set to {told} bit/s, not {asked}; set transport.bitrate"
            + (" and transport.data_bitrate" if fd else "")
            + f" to what the bus has, or `sudo ip link set {channel} down; sudo ip link set {channel} "
            f"type can bitrate {bitrate}{data}; sudo ip link set {channel} up`"
        )


def rates(said: str) -> tuple[int, int]:
    """Return nominal and data bit rate [bit/s] in what ``ip -details -json link show`` said; 0: none."""
    try:
        data = json.loads(said)[0]["linkinfo"]["info_data"]
        nominal, fast = (int(data.get(k, {}).get("bitrate", 0)) for k in ("bittiming", "data_bittiming"))
    except (ValueError, LookupError, TypeError, AttributeError):
        return 0, 0
    return nominal, fast


def _ip(channel: str) -> str:
    program = shutil.which("ip")
    if program is None:
        return ""
    command = [program, "-details", "-json", "link", "show", "dev", channel]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=IP_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return ""
    return done.stdout
