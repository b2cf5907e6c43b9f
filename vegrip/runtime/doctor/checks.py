"""The checks of the machine itself: what the kernel says below ``root``, and what can be measured.

``root`` is ``/`` on a machine and a folder in tests. Nothing is changed.
"""

import math
import platform
import shutil
import statistics
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from vegrip.runtime.doctor.finding import Finding, fail, ok, warn

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
    """How late a sleep of two milliseconds ends."""
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
    """What decides the frequency of the processors."""
    files = sorted((root / "sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor"))
    found = {_read(file) for file in files} - {""}
    if not found:
        return ok("processor", "frequency is not governed here, as in most virtual machines")
    if found == {"performance"}:
        return ok("processor", "governor performance")
    remedy = "sudo cpupower frequency-set -g performance"
    return warn("processor", f"governor {', '.join(sorted(found))}: waking up takes longer", remedy)


def disk(folder: Path) -> Finding:
    """The room for recordings."""
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
