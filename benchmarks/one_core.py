"""The grasp force node on one core, five fingers at 500 Hz, for a minute: how many commands are late.

``python -m benchmarks.one_core [--seconds 60] [--core 0] [--priority 10]``. The node, with every
thread and helper process it starts, has one core; hand and bus have the others, as they would be elsewhere.
On a machine that does other work too the figures tell of that: how long the node waited for its core while it
could have run is printed beside them. ``--priority`` gives node, hand and bus a real-time priority, which
needs the right to it (``vegrip doctor`` says how).
"""

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from benchmarks._nodes import private_runtime, running
from vegrip.clock import NS
from vegrip.host.realtime import switched
from vegrip.runtime.registry import ask, find_node

CHANNEL = "transport.channel=onecore"
TICKS = os.sysconf("SC_CLK_TCK")


@contextmanager
def placed(cores: set[int], priority: int) -> Iterator[None]:
    """Let what is started in this context run on ``cores`` only, with a real-time ``priority`` unless 0."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    if priority:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(priority))
    try:
        with switched(on=priority > 0):
            yield
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        os.sched_setaffinity(0, before)


def measured(seconds: int, core: int, priority: int) -> dict[str, Any]:
    """Return what the node says of itself, and what the kernel says of it."""
    others = os.sched_getaffinity(0) - {core}
    if not others:
        raise SystemExit("one_core: hand and bus need a second core")
    with ExitStack() as stack:
        stack.enter_context(private_runtime())
        with placed(others, priority):
            stack.enter_context(running("virtual_hand", CHANNEL))
        with placed({core}, priority):
            stack.enter_context(running("grasp_force", CHANNEL))
        node = find_node("grasp_force")
        rows, used, waited = [], _used(node.pid), _waited(node.pid)
        started = time.monotonic()
        for _ in range(seconds):
            time.sleep(1.0)
            rows.append(ask(node, "status"))
        elapsed = time.monotonic() - started
        used, waited = _used(node.pid) - used, _waited(node.pid) - waited
    return {
        "seconds": round(elapsed, 1),
        "commands": round(sum(row["rate_out"] for row in rows)),
        "deadline_misses": rows[-1]["deadline_misses"],
        "latency_us": {
            "p50_median_second": statistics.median(row["latency_p50"] for row in rows),
            "p99_median_second": statistics.median(row["latency_p99"] for row in rows),
            "p99_worst_second": max(row["latency_p99"] for row in rows),
            "max": max(row["latency_max"] for row in rows),
        },
        "seconds_with_misses": sum(b["deadline_misses"] > a["deadline_misses"] for a, b in pairwise(rows)),
        "share_of_the_core": round(used / elapsed, 3),
        "share_waited_for_the_core": round(waited / elapsed, 3),
    }


def _used(pid: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def _waited(pid: int) -> float:
    """Return for how long the thread of the loop was ready to run and did not [s]."""
    return int(Path(f"/proc/{pid}/task/{pid}/schedstat").read_text(encoding="ascii").split()[1]) / NS


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; exit code 1 when a command was late."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--core", type=int, default=min(os.sched_getaffinity(0)))
    parser.add_argument("--priority", type=int, default=0, help="real-time priority, 1 to 99; 0: none")
    given = parser.parse_args(arguments)
    found = measured(given.seconds, given.core, given.priority)
    print(json.dumps(found, indent=1))
    return int(found["deadline_misses"] > 0)


if __name__ == "__main__":
    sys.exit(main())
