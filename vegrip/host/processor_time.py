"""Processor time of any process of this machine, as the kernel counts it."""

import math
import os
from pathlib import Path

FIELDS_BEFORE_TIMES = 11
"""Of the line behind the name of the program; user and system time follow."""


def processor_time(process: int) -> float:
    """Return the time [s] that all threads of a process took so far, NaN where it is not known."""
    try:
        line = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return math.nan
    user, system = line.rpartition(")")[2].split()[FIELDS_BEFORE_TIMES : FIELDS_BEFORE_TIMES + 2]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
