"""State in to command out: the grasp force node against a node that does no physics, on the same bus.

Five simulated fingers at 500 Hz on the virtual CAN FD bus, each program in a process of its own. The figure
is the median over seconds of the 99th percentile that the node itself measures, from the end of the frame of
the state on the bus to the command handed to the bus.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

from vegrip.errors import VegripError
from vegrip.node.client import ask
from vegrip.node.registry import find_node

SECONDS = 10
PATIENCE = 90.0  # [s] for a first start, which compiles


def run() -> dict[str, dict[str, float]]:
    """Measure both, one after the other."""
    with (
        tempfile.TemporaryDirectory(prefix="vg-") as folder,
        mock.patch.dict(os.environ, VEGRIP_RUNTIME_DIR=f"{folder}/r"),
    ):
        ours, theirs = _p99("grasp_force"), _p99("echo")
    return {"node_p99_vs_echo": {"ours_us": ours, "theirs_us": theirs, "ratio": theirs / ours}}


def _p99(program: str) -> float:
    channel = ("--set", f"transport.channel=bench-{program}")
    with _running(program, *channel), _running("virtual_hand", *channel):
        time.sleep(1.0)
        return statistics.median(_each_second(program))


def _each_second(program: str) -> Iterator[float]:
    for _ in range(SECONDS):
        time.sleep(1.0)
        yield ask(find_node(program), "status")["latency_p99"]


@contextmanager
def _running(program: str, *settings: str) -> Iterator[None]:
    process = subprocess.Popen(
        [sys.executable, "-m", "vegrip", "node", program, *settings], stderr=subprocess.DEVNULL
    )
    try:
        _wait_until_active(program, process)
        yield
    finally:
        process.terminate()
        process.wait()


def _wait_until_active(program: str, process: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and process.poll() is None:
        try:
            if ask(find_node(program), "state", patience=1.0)["state"] == "active":
                return
        except VegripError:
            pass  # not there yet
        time.sleep(0.1)
    raise VegripError(f"{program} does not start; try `vegrip node {program}`")
