"""``vegrip doctor``: whether this machine can run a hand, and what to do where it cannot.

What the kernel says below ``root`` (``/`` on a machine, a folder in tests), what this user may do, what
``ip`` says of CAN interfaces, and what can be measured. Nothing is changed.
"""

import json
import math
import os
import platform
import shutil
import socket
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from pathlib import Path
from typing import Any

from vegrip.errors import DeviceError
from vegrip.host import realtime
from vegrip.host.folders import runtime_folder
from vegrip.host.realtime import Permission
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.open import settings_of_map


class Grade(IntEnum):
    """How well it is."""

    OK = 0
    WARN = 1  # it runs, but may miss deadlines, or something is left unused
    FAIL = 2  # it will not run


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report."""

    check: str
    grade: Grade
    text: str
    remedy: str = ""  # what to type or set; "" when there is nothing to do


def worst(findings: Iterable[Finding]) -> Grade:
    return max((finding.grade for finding in findings), default=Grade.OK)


def ok(check: str, text: str) -> Finding:
    return Finding(check, Grade.OK, text)


def warn(check: str, text: str, remedy: str) -> Finding:
    return Finding(check, Grade.WARN, text, remedy)


def fail(check: str, text: str, remedy: str) -> Finding:
    return Finding(check, Grade.FAIL, text, remedy)


LATE = 1e-3  # [s] a sleep that ends so late costs a 500 Hz loop half its period
COARSE = 1e-6  # [s]
LITTLE_DISK = 1e9  # [bytes] half an hour of five fingers with everything that is said of them
NO_DISK = 5e7  # [bytes]


def kernel(root: Path) -> Finding:
    """Linux, and whether it is a preemptible one."""
    system, release = platform.system(), platform.release()
    if system != "Linux":
        return warn(
            "kernel", f"{system} {release}", "the virtual bus and SocketCAN need Linux; ZeroMQ runs here"
        )
    realtime = _read(root / "sys/kernel/realtime") == "1"
    version = _read(root / "proc/sys/kernel/version")
    kind = next((kind for kind in ("PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT") if kind in version), "")
    return ok("kernel", f"Linux {release} {'PREEMPT_RT' if realtime else kind}".rstrip())


def clock_source(root: Path) -> Finding:
    """The hardware behind the monotonic clock."""
    folder = root / "sys/devices/system/clocksource/clocksource0"
    current = _read(folder / "current_clocksource")
    if not current:
        return warn("clock source", "not readable", "ignore this if `vegrip doctor` finds the clock fine")
    if current in ("tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"):
        return ok("clock source", current)
    remedy = f"echo tsc | sudo tee {folder / 'current_clocksource'}, if `tsc` is among the available ones"
    return warn("clock source", f"{current}: reading the clock is slow", remedy)


def clock(now: Callable[[], int] = time.monotonic_ns) -> Finding:
    """The resolution of the monotonic clock, as it is seen from here."""
    ticks = [now() for _ in range(2000)]
    steps = [b - a for a, b in pairwise(ticks) if b > a]
    step = statistics.median(steps) * 1e-9 if steps else math.inf
    if step > COARSE:
        return warn("clock", f"moves in steps of {step * 1e6:.1f} us", "use another clock source, see above")
    return ok("clock", f"read in {step * 1e9:.0f} ns")


def wake_up(sleep: Callable[[float], None] = time.sleep, count: int = 100) -> Finding:
    late = []
    for _ in range(count):
        start = time.monotonic()
        sleep(0.002)
        late.append(time.monotonic() - start - 0.002)
    usual, longest = statistics.median(late), max(late)
    text = f"sleeps end {usual * 1e6:.0f} us late, {longest * 1e6:.0f} us at worst of {count}"
    if longest > LATE:
        return warn("wake-up", text, "close other programs, or give the node a core and real-time priority")
    return ok("wake-up", text)


def governor(root: Path) -> Finding:
    files = sorted((root / "sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor"))
    found = {_read(file) for file in files} - {""}
    if not found:
        return ok("processor", "frequency is not governed here, as in most virtual machines")
    if found == {"performance"}:
        return ok("processor", "governor performance")
    remedy = "sudo cpupower frequency-set -g performance"
    return warn("processor", f"governor {', '.join(sorted(found))}: waking up takes longer", remedy)


def disk(folder: Path) -> Finding:
    free = shutil.disk_usage(folder).free
    text = f"{free / 1e9:.1f} GB free in {folder}"
    remedy = "make room, or record to another disk with parameters.folder of the record node"
    if free < NO_DISK:
        return fail("disk", text, remedy)
    return warn("disk", text, remedy) if free < LITTLE_DISK else ok("disk", text)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError):
        return ""


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


VIRTUAL = "the virtual bus (interface = vegrip) needs none"


def raw_sockets() -> Finding:
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


def largest_forces(path: Path) -> list[Finding]:
    """What bounds the grip of each hand of a launch file, or of a map: stated, of the map, or nothing."""
    found = []
    for node in read_launch_file(path):
        if node.program != "grasp_force":
            continue
        force, check = node.parameters.get("limits", {}).get("max_force"), f"{node.full_name[1:]} limit"
        file = node.transport.get("map", "")
        by_map = settings_of_map(Path(file)).get("limits", {}).get("max_force") if file else None
        if force is None:
            text = "limits.max_force is stated neither here nor by a map, so it is 15 N"
            remedy = f"parameters.limits.max_force = 8.0 below its [[node]] in {path}, or [limits] of a map"
            found.append(warn(check, text, remedy))
        else:
            found.append(
                ok(check, f"limits.max_force is {force} N{f', by {file}' if by_map == force else ''}")
            )
    return found


def examine(root: Path = Path("/"), recordings: Path = Path()) -> list[Finding]:
    """Return what was found; takes about half a second, changes nothing."""
    return [
        kernel(root),
        clock_source(root),
        clock(),
        wake_up(),
        governor(root),
        priority(),
        sockets(),
        compiler_cache(),
        raw_sockets(),
        *interfaces(),
        disk(recordings.resolve()),
    ]
