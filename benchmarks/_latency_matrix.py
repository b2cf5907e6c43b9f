"""State in, command out: the node that grips against an echo, over every link, number of fingers and rate.

``make latency``, or ``python -m benchmarks._latency_matrix --help``. A hand plays recorded states in
bursts, all fingers at once as hands do, and measures until it has the command, over the link there and back.
The echo runs in the same loop, on the same link, with the same codec, and does no physics. More than five
fingers are several hands, each with a node of its own. A kernel without SocketCAN is replaced by
User-Mode-Linux, with one slow processor and rates that it can carry.
"""

import argparse
import json
import os
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from benchmarks._latency_feed import FINGERS, Feed, Felt, feed, record
from benchmarks._nodes import private_runtime, running
from vegrip.runtime.statistics import Histogram
from vegrip.transport.canbus.frame_time import BitTiming, typical_duration

PROGRAMS = ("grasp_force", "echo")
LINKS = ("virtual", "vcan", "ipc", "tcp")
PORT = 47_310  # and the next ones, on loopback
FULL = 0.9  # share of the bus above which it is not run
STATE, COMMAND = 48, 24  # [bytes] of the frames of a finger, CAN FD


@dataclass(frozen=True)
class Plan:
    """What is measured."""

    links: tuple[str, ...] = LINKS
    fingers: tuple[int, ...] = (1, 5, 20)
    rates: tuple[float, ...] = (100.0, 250.0, 500.0, 1000.0)
    seconds: float = 2.0
    warm: float = 0.3


SLOW = Plan(("vcan",), (1, 5), (50.0, 100.0), 3.0, 1.0)
"""What User-Mode-Linux can carry."""


@dataclass(frozen=True)
class Cell:
    """One program on one link with a number of fingers at a rate; latencies in microseconds."""

    link: str
    fingers: int
    rate: float  # [Hz]
    program: str
    sent: int
    misses: int  # later than 10 ms, or never
    p50: float
    p99: float
    p999: float
    max: float


def measured(plan: Plan) -> Iterator[Cell]:
    """Measure cell by cell."""
    with private_runtime(), tempfile.TemporaryDirectory(prefix="vg-") as folder:
        states = Path(folder) / "states.npy"
        record(states)
        with ProcessPoolExecutor(4, get_context("spawn")) as pool:
            for link in plan.links:
                for fingers in plan.fingers:
                    rates = tuple(rate for rate in plan.rates if _fits(link, fingers, rate))
                    for program in PROGRAMS if rates else ():
                        yield from _column(pool, replace(plan, rates=rates), link, fingers, program, states)


def _fits(link: str, fingers: int, rate: float) -> bool:
    timing = BitTiming()
    busy = typical_duration(STATE, True, timing) + typical_duration(COMMAND, True, timing)
    return link != "virtual" or fingers * rate * busy / 1e9 < FULL


def _column(
    pool: ProcessPoolExecutor, plan: Plan, link: str, fingers: int, program: str, states: Path
) -> Iterator[Cell]:
    hands = -(-fingers // len(FINGERS))
    each = min(fingers, len(FINGERS))
    label = f"{link}-{fingers}-{program}"
    with ExitStack() as stack:
        feeds = []
        for hand in range(hands):
            ours, theirs = _ends(link, label, hand)
            settings = [f"hand={hand}", f"namespace=h{hand}", f"fingers={json.dumps(FINGERS[:each])}"]
            settings += [f"transport.{key}={json.dumps(value)}" for key, value in theirs.items()]
            stack.enter_context(running(program, *settings, name=f"{program}{hand}"))
            feeds.append(Feed(ours, each, hand, f"h{hand}", plan.rates, plan.seconds, plan.warm, states))
        felt = list(pool.map(feed, feeds))
    for rate, of_hands in zip(plan.rates, zip(*felt, strict=True), strict=True):
        yield _cell(link, fingers, rate, program, of_hands)


def _ends(link: str, label: str, hand: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the transport of the hand and that of its node."""
    if link in ("virtual", "vcan"):
        interface = {"virtual": "vegrip", "vcan": "socketcan"}[link]
        table = {"kind": "can", "interface": interface, "channel": "vcan0" if link == "vcan" else label}
        return table, table
    first = PORT + 2 * hand
    names = (
        (f"tcp://127.0.0.1:{first}", f"tcp://127.0.0.1:{first + 1}")
        if link == "tcp"
        else (f"ipc:{label}-{hand}-a", f"ipc:{label}-{hand}-b")
    )
    ours, theirs = (
        {"kind": "zmq", "publish": own, "subscribe": [other]} for own, other in (names, names[::-1])
    )
    return ours, theirs


def _cell(link: str, fingers: int, rate: float, program: str, felt: Sequence[Felt]) -> Cell:
    latency = Histogram.sum_of(part.counts for part in felt)
    p50, p99, p999 = (latency.percentile(share) / 1e3 for share in (0.5, 0.99, 0.999))
    sent, misses = (sum(getattr(part, name) for part in felt) for name in ("sent", "misses"))
    return Cell(link, fingers, rate, program, sent, misses, p50, p99, p999, latency.maximum / 1e3)


# --- the table


def markdown(cells: Sequence[Cell]) -> str:
    """Return a row for each link, number of fingers and rate."""
    found = {(cell.link, cell.fingers, cell.rate, cell.program): cell for cell in cells}
    lines = [
        "| link | fingers | rate "
        "| p50 | p99 | p99.9 | max | late | echo p50 | p99 | p99.9 | max | late | p99 ratio |",
        "|---|---|---|" + "---|" * 11,
    ]
    for link, fingers, rate, program in found:
        if program == PROGRAMS[0]:
            ours, theirs = (found.get((link, fingers, rate, each)) for each in PROGRAMS)
            lines.append(_row(ours, theirs))
    return "\n".join(lines)


def _row(ours: Cell | None, theirs: Cell | None) -> str:
    if ours is None or theirs is None:
        return ""
    cells = [ours.link, str(ours.fingers), f"{ours.rate:g} Hz", *_figures(ours), *_figures(theirs)]
    return "| " + " | ".join([*cells, f"{ours.p99 / theirs.p99:.2f}"]) + " |"


def _figures(cell: Cell) -> list[str]:
    times = [f"{value / 1e3:.2f}" for value in (cell.p50, cell.p99, cell.p999, cell.max)]
    return [*times, f"{cell.misses} of {cell.sent}"]


# --- where the kernel has no SocketCAN


def _has_vcan() -> bool:
    return "vcan0" in {name for _, name in socket.if_nameindex()}


def _elsewhere(plan: Plan) -> list[Cell]:
    """Measure over vcan inside what ``tests/vcan/run`` finds."""
    runner = Path.cwd() / "tests/vcan/run"
    if not runner.exists():
        print("vcan: this kernel has no vcan0; run this from the source tree", file=sys.stderr)
        return []
    command = [
        str(runner),
        sys.executable,
        "-m",
        "benchmarks._latency_matrix",
        "--json",
        *_options(plan),
    ]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False, env=os.environ)
    if done.returncode:
        print(f"vcan: not measured, {runner} ended with code {done.returncode}", file=sys.stderr)
        return []
    return [Cell(**cell) for cell in json.loads(done.stdout)["cells"]]


def _options(plan: Plan) -> list[str]:
    lists = {"--links": plan.links, "--fingers": plan.fingers, "--rates": plan.rates}
    options = [part for name, values in lists.items() for part in (name, *map(str, values))]
    return [*options, "--seconds", str(plan.seconds), "--warm", str(plan.warm)]


def _plan(arguments: Sequence[str] | None) -> tuple[Plan, argparse.Namespace]:
    usual = Plan()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--links", nargs="+", choices=LINKS, default=usual.links)
    parser.add_argument(
        "--fingers", nargs="+", type=int, default=usual.fingers, help="1 to 5, or hands of five"
    )
    parser.add_argument("--rates", nargs="+", type=float, default=usual.rates, help="[Hz]")
    parser.add_argument("--seconds", type=float, default=usual.seconds, help="of each cell")
    parser.add_argument("--warm", type=float, default=usual.warm, help="[s] before them")
    parser.add_argument("--json", action="store_true", help="print one JSON object, else a table in markdown")
    given = parser.parse_args(arguments)
    plan = Plan(tuple(given.links), tuple(given.fingers), tuple(given.rates), given.seconds, given.warm)
    return plan, given


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print."""
    plan, given = _plan(arguments)
    here = tuple(link for link in plan.links if link != "vcan" or _has_vcan())
    cells = []
    for cell in measured(replace(plan, links=here)):
        print(
            f"{cell.link} {cell.fingers} {cell.rate:g} Hz {cell.program}: {cell.p99:.0f} us", file=sys.stderr
        )
        cells.append(cell)
    if here != plan.links:
        cells += _elsewhere(SLOW)
    print(json.dumps({"cells": [asdict(cell) for cell in cells]}) if given.json else markdown(cells))
    return 0


if __name__ == "__main__":
    sys.exit(main())
