"""Why a process that runs does not answer: it is still starting, it was stopped, or it is stuck."""

import os
import time
from pathlib import Path

STARTS_WITHIN = 60.0  # [s] a node that is so young may still import and open its bus
PROC = Path("/proc")
_STOPPED = ("T", "t")  # by a signal, by a debugger; proc(5)


def silent_state(pid: int) -> str:
    """Return ``starting``, ``stopped``, ``stuck`` or ``ended``: what a process is that does not answer."""
    try:
        # the name in parentheses may hold anything; state is the first field behind it, starttime the 20th
        fields = (PROC / str(pid) / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        state, start_ticks = fields[0], int(fields[19])
    except (OSError, IndexError, ValueError):
        return "ended"
    if state in _STOPPED:
        return "stopped"
    age = time.clock_gettime(time.CLOCK_BOOTTIME) - start_ticks / os.sysconf("SC_CLK_TCK")
    return "starting" if age < STARTS_WITHIN else "stuck"
