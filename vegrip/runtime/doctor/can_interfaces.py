"""CAN: whether the kernel has it, and how its interfaces stand. Asks ``ip``; changes nothing."""

import json
import shutil
import socket
import subprocess
from collections.abc import Callable, Mapping
from typing import Any

from vegrip.runtime.doctor.finding import Finding, fail, ok, warn

VIRTUAL = "the virtual bus (interface = vegrip) needs none"


def raw_sockets() -> Finding:
    """Whether a CAN socket can be opened."""
    family = getattr(socket, "AF_CAN", None)
    if family is None:
        return warn("SocketCAN", "this Python has no CAN sockets", VIRTUAL)
    try:
        socket.socket(family, socket.SOCK_RAW, getattr(socket, "CAN_RAW", 1)).close()
    except OSError as error:
        reason = error.strerror or error
        return warn("SocketCAN", f"no CAN sockets ({reason})", f"sudo modprobe can_raw; {VIRTUAL}")
    return ok("SocketCAN", "the kernel has it, and this user may use it")


def interfaces(ask: Callable[[], str | None] | None = None) -> list[Finding]:
    """Return a finding for each CAN interface."""
    said = (ask or _ip)()
    if said is None:
        return [warn("CAN", "the program `ip` is missing", "sudo apt install iproute2")]
    try:
        links = [link for link in json.loads(said or "[]") if _kind(link)]
    except ValueError:
        return [
            warn("CAN", "the program `ip` is too old: its output cannot be read", "sudo apt install iproute2")
        ]
    if not links:
        return [ok("CAN", f"no interface; {VIRTUAL}")]
    return [_judged(link) for link in links]


def _judged(link: Mapping[str, Any]) -> Finding:
    name, kind = str(link.get("ifname", "?")), _kind(link)
    up = "UP" in link.get("flags", [])
    data = link.get("linkinfo", {}).get("info_data", {})
    bitrate = data.get("bittiming", {}).get("bitrate", 0)
    text = ", ".join(filter(None, (kind, "up" if up else "down", _rates(data), str(data.get("state", "")))))
    if kind == "can" and not bitrate:
        remedy = f"sudo ip link set {name} type can bitrate 1000000 dbitrate 5000000 fd on restart-ms 100"
        return fail(name, f"{text}: no bit rate", remedy)
    if not up:
        return warn(name, text, f"sudo ip link set {name} up")
    if data.get("state") == "BUS-OFF":
        return fail(
            name, text, f"check wiring, termination and bit rate; sudo ip link set {name} type can restart"
        )
    if kind == "can" and not data.get("restart_ms"):
        remedy = f"sudo ip link set {name} down; sudo ip link set {name} type can restart-ms 100; up again"
        return warn(name, f"{text}: it stays off after a bus-off", remedy)
    if link.get("mtu", 0) < 72:
        return ok(name, f"{text}; classic frames only")
    return ok(name, text)


def _rates(data: Mapping[str, Any]) -> str:
    nominal = data.get("bittiming", {}).get("bitrate", 0)
    fast = data.get("data_bittiming", {}).get("bitrate", 0)
    return " and ".join(f"{rate} bit/s" for rate in (nominal, fast) if rate)


def _kind(link: Mapping[str, Any]) -> str:
    if link.get("link_type") != "can":
        return ""
    return str(link.get("linkinfo", {}).get("info_kind", "can"))


def _ip() -> str | None:
    program = shutil.which("ip")
    if program is None:
        return None
    command = [program, "-details", "-json", "link", "show"]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=10).stdout
