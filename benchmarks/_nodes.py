"""Nodes as processes of their own, for benchmarks, in a runtime folder of their own."""

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

from vegrip.errors import VegripError
from vegrip.runtime.registry import ask, find_node

PATIENCE = 180.0  # [s] for a first start, which compiles


@contextmanager
def private_runtime() -> Iterator[None]:
    """Keep nodes and buses of this benchmark apart from all others."""
    with (
        tempfile.TemporaryDirectory(prefix="vg-") as folder,
        mock.patch.dict(os.environ, VEGRIP_RUNTIME_DIR=f"{folder}/r"),
    ):
        yield


@contextmanager
def running(program: str, *settings: str, name: str = "") -> Iterator[None]:
    """Run ``program`` with ``KEY=VALUE`` settings from when it is active on."""
    name = name or program
    options = [part for setting in settings for part in ("--set", setting)]
    process = subprocess.Popen(
        [sys.executable, "-m", "vegrip", "node", program, "--name", name, *options], stderr=subprocess.DEVNULL
    )
    try:
        _wait_until_active(name, process)
        yield
    finally:
        process.terminate()
        process.wait()


def latencies_p99(name: str, seconds: int) -> list[float]:
    """Return the 99th percentile [us] of ``seconds`` seconds in which the node answered something.

    Raises:
        VegripError: there are not so many within ``PATIENCE`` s more.

    """
    node, found = find_node(name), list[float]()
    deadline = time.monotonic() + seconds + PATIENCE
    while len(found) < seconds:
        if time.monotonic() > deadline:
            raise VegripError(f"{name} answers nothing; is the machine too busy for it?")
        time.sleep(1.0)
        latest = float(ask(node, "status")["latency_p99"])
        if math.isfinite(latest):  # NaN: nothing was answered in this second
            found.append(latest)
    return found


def _wait_until_active(name: str, process: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and process.poll() is None:
        try:
            if ask(find_node(name), "state", patience=1.0)["state"] == "active":
                return
        except VegripError:
            pass  # not there yet
        time.sleep(0.1)
    raise VegripError(f"{name} does not start; try `vegrip node {name}`")
