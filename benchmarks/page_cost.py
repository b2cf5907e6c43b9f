"""What the live page costs beside a node: five fingers at 500 Hz, with a page that is watched and without.

``python -m benchmarks.page_cost [--pairs 4] [--priority 10]`` prints the 99th percentile of the node
with and without the page, and the processor time of both processes. With and without take turns, so that
other work on the machine falls on both. The watcher reads the events as a browser does and draws nothing.
``--priority`` gives node, hand and bus a real-time priority, as on a hand. ``--beside bridges`` measures the
bridges to ROS 2, MCAP and Foxglove instead of the page, each of which takes every topic.
"""

import argparse
import http.client
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks._nodes import latencies_p99, private_runtime, running
from benchmarks.one_core import placed
from vegrip.errors import VegripError
from vegrip.runtime.registry import find_node

CHANNEL = "transport.channel=page-cost"
PAIRS = 2  # of turns
WINDOW = 6  # [s] measured, of each turn
SETTLE = 2.0  # [s] before
PATIENCE = 60.0  # [s] for the page to open
SMALLEST = {"PAIRS": 1, "WINDOW": 1, "SETTLE": 0.0}
ROS_DOMAIN = "97"
TICKS = os.sysconf("SC_CLK_TCK")


@dataclass
class Turns:
    """What was measured, with or without the page."""

    p99: list[float] = field(default_factory=list)  # [us]
    node: list[float] = field(default_factory=list)  # cores
    page: list[float] = field(default_factory=list)  # cores


def run() -> dict[str, dict[str, float]]:
    """Measure the node with the page (ours) and without (theirs)."""
    told = measured(pairs=PAIRS, priority=0)
    ours, theirs = told["p99_with_us"], told["p99_without_us"]
    return {"node_p99_with_page": {"ours_us": ours, "theirs_us": theirs, "ratio": theirs / ours}}


def measured(pairs: int, priority: int, beside: str = "page") -> dict[str, Any]:
    """Return medians over all seconds, with the page and without."""
    without, watched = Turns(), Turns()
    with ExitStack() as stack:
        stack.enter_context(private_runtime())
        with placed(os.sched_getaffinity(0), priority):
            stack.enter_context(running("grasp_force", CHANNEL))
            stack.enter_context(running("virtual_hand", CHANNEL))
        for _ in range(pairs):
            _measure(without, ())
            with BESIDE[beside]() as pids:
                _measure(watched, pids)
    return {
        "p99_with_us": statistics.median(watched.p99),
        "p99_without_us": statistics.median(without.p99),
        "p99_ratio": statistics.median(watched.p99) / statistics.median(without.p99),
        "node_cores_with": statistics.mean(watched.node),
        "node_cores_without": statistics.mean(without.node),
        "page_cores": statistics.mean(watched.page),
    }


@contextmanager
def page() -> Iterator[Sequence[int]]:
    """Serve the live page, let a watcher read it, and yield its process number."""
    with subprocess.Popen(
        [sys.executable, "-m", "vegrip", "monitor", "--web", "--port", "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        assert process.stdout is not None
        found = re.search(r"127\.0\.0\.1:(\d+)/\?key=(\S+)", process.stdout.readline())
        if found is None:
            raise VegripError("the page does not open; pip install 'vegrip[web]'")
        watcher = threading.Thread(target=_watch, args=(int(found[1]), found[2]), daemon=True)
        watcher.start()
        try:
            yield (process.pid,)
        finally:
            process.terminate()
            watcher.join()


@contextmanager
def bridges() -> Iterator[Sequence[int]]:
    """Run all bridges, each of which takes every topic, and yield their process numbers."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        words = (
            ["ros2", "--domain", ROS_DOMAIN],
            ["mcap", "-o", f"{folder}/all.mcap"],
            ["foxglove", "--port", "0"],
        )
        started = [
            stack.enter_context(
                subprocess.Popen(
                    [sys.executable, "-m", "vegrip", "bridge", *one], stdout=subprocess.PIPE, text=True
                )
            )
            for one in words
        ]
        assert started[-1].stdout is not None
        found = re.search(r"ws://127\.0\.0\.1:(\d+)", started[-1].stdout.readline())
        if found is None:
            raise VegripError("the bridge to Foxglove does not open; pip install 'vegrip[foxglove]'")
        client = threading.Thread(target=_subscribe_to_all, args=(int(found[1]),), daemon=True)
        client.start()
        try:
            yield [process.pid for process in started]
        finally:
            for process in started:
                process.terminate()
            client.join()


def _subscribe_to_all(port: int) -> None:
    """Read every channel, as a client that shows all, until there is no more."""
    from websockets.exceptions import ConnectionClosed  # noqa: PLC0415 (an extra)
    from websockets.sync.client import connect  # noqa: PLC0415
    from websockets.typing import Subprotocol  # noqa: PLC0415

    with (
        suppress(ConnectionClosed),
        connect(f"ws://127.0.0.1:{port}", subprotocols=[Subprotocol("foxglove.sdk.v1")]) as socket,
    ):
        for said in socket:
            told = json.loads(said) if isinstance(said, str) else {}
            new = [{"id": one["id"], "channelId": one["id"]} for one in told.get("channels", ())]
            if new:
                socket.send(json.dumps({"op": "subscribe", "subscriptions": new}))


BESIDE: dict[str, Callable[[], AbstractContextManager[Sequence[int]]]] = {"page": page, "bridges": bridges}


def _watch(port: int, key: str) -> None:
    """Read the events until there are no more."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    connection.request("GET", "/live", headers={"cookie": f"vegrip-{port}={key}"})
    answer = connection.getresponse()
    try:
        while answer.read1(65_536):
            pass
    except (OSError, http.client.HTTPException):
        pass  # the page was ended
    connection.close()


def _measure(turns: Turns, pids: Sequence[int]) -> None:
    time.sleep(SETTLE)
    node = find_node("grasp_force")
    before, page_before = _used(node.pid), sum(map(_used, pids))
    started = time.monotonic()
    turns.p99 += latencies_p99("grasp_force", WINDOW)
    passed = time.monotonic() - started
    turns.node.append((_used(node.pid) - before) / passed)
    turns.page.append((sum(map(_used, pids)) - page_before) / passed)


def _used(pid: int) -> float:
    """Return the processor time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="The cost of the live page beside a node.")
    parser.add_argument("--pairs", type=int, default=4)
    parser.add_argument("--priority", type=int, default=0)
    parser.add_argument("--beside", choices=BESIDE, default="page")
    given = parser.parse_args()
    print(json.dumps(measured(given.pairs, given.priority, given.beside), indent=2))


if __name__ == "__main__":
    main()
