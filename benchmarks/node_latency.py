"""State in to command out: the grasp force node against a node that does no physics, on the same bus.

Five simulated fingers at 500 Hz on the virtual CAN FD bus, each program in a process of its own. The figure
is the median over seconds of the 99th percentile that the node itself measures, from the end of the frame of
the state on the bus to the command handed to the bus.
"""

import math
import statistics
import time
from collections.abc import Iterator

from vegrip.benchmarks._nodes import private_runtime, running

from vegrip.runtime.client import ask
from vegrip.runtime.registry import find_node

SECONDS = 10
PATIENCE = 60.0  # [s] for the first command
SMALLEST = {"SECONDS": 1}


def run() -> dict[str, dict[str, float]]:
    """Measure both, one after the other."""
    with private_runtime():
        ours, theirs = _p99("grasp_force"), _p99("echo")
    return {"node_p99_vs_echo": {"ours_us": ours, "theirs_us": theirs, "ratio": theirs / ours}}


def _p99(program: str) -> float:
    channel = f"transport.channel=bench-{program}"
    with running(program, channel), running("virtual_hand", channel):
        deadline = time.monotonic() + PATIENCE
        while not math.isfinite(_latest(program)) and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(1.0)
        return statistics.median(_each_second(program))


def _each_second(program: str) -> Iterator[float]:
    for _ in range(SECONDS):
        time.sleep(1.0)
        yield _latest(program)


def _latest(program: str) -> float:
    """Return the 99th percentile of the last second [us], NaN where nothing was answered."""
    return float(ask(find_node(program), "status")["latency_p99"])
