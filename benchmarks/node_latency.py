"""State in to command out: the grasp force node against a node that does no physics, on the same bus.

Five simulated fingers at 500 Hz on the virtual CAN FD bus, each program in a process of its own. The figure
is the median over seconds of the 99th percentile that the node itself measures, from the end of the frame of
the state on the bus to the command handed to the bus.
"""

import statistics

from benchmarks._nodes import latencies_p99, private_runtime, running

SECONDS = 10
SMALLEST = {"SECONDS": 1}


def run() -> dict[str, dict[str, float]]:
    """Measure both, one after the other."""
    with private_runtime():
        ours, theirs = _p99("grasp_force"), _p99("echo")
    return {"node_p99_vs_echo": {"ours_us": ours, "theirs_us": theirs, "ratio": theirs / ours}}


def _p99(program: str) -> float:
    channel = f"transport.channel=bench-{program}"
    with running(program, channel), running("virtual_hand", channel):
        latencies_p99(program, 1)  # the first second contains the start
        return statistics.median(latencies_p99(program, SECONDS))
