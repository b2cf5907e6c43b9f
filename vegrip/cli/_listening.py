"""The traffic of a hand for ``vegrip connect``: of a log, or live with questions and a picture of it."""

import math
import sys
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from vegrip.cli._terminal import printer, table
from vegrip.clock import NS
from vegrip.config import build
from vegrip.connect.traffic import Now, Traffic, traffic_of
from vegrip.identification.recording.can_frames import read_log
from vegrip.transport.can_port import open_port
from vegrip.transport.open import CanSettings, open_bus

if TYPE_CHECKING:
    from rich.table import Table

PICTURE_PERIOD_S = 0.1  # [s] between two pictures of live values
QUESTIONS = {
    "rest": "leave all fingers in the air",
    "press": "press each fingertip on something along its normal, and release it",
    "shear": "pull each fingertip along its +x while it touches",
    "twist": "turn what it touches counter-clockwise about its outward normal",
}


def traffic_of_hand(
    log: Path | None,
    transport: Mapping[str, Any],
    windows: dict[str, tuple[float, float]],
    seconds: float,
    now: Now | None,
    *,
    ask: bool,
    channel: str = "",
    wanted: Collection[int] = (),
) -> Traffic | None:
    """Return the traffic of ``log``, or what comes on ``transport``; None where neither is given.

    Live it lasts as long as the ``windows``, or for each question, whose windows are added.
    """
    if log is not None:
        read = read_log(log, extended=True, channel=channel, wanted=wanted)
        return traffic_of(read.frames, read.report)
    if not transport:
        return None
    bus, _, timing = open_bus(build(CanSettings, transport, "--channel"))
    port = open_port(bus, Counter(), timing, extended=True)
    traffic = Traffic()
    shown = now if sys.stdout.isatty() else None

    def take(until: float) -> None:
        with _showing(shown) as draw:
            while (left := until - time.monotonic()) > 0.0:
                frame = port.receive(min(left, 0.1))
                if frame is not None:
                    traffic.add(frame)
                    if shown is not None:
                        shown.update(frame)
                draw()

    try:
        if not (ask and sys.stdin.isatty() and not windows):
            take(time.monotonic() + max([seconds, *(end for _, end in windows.values())]))
            return traffic
        for name, what in QUESTIONS.items():
            typer.echo(f"{name}: for {seconds:g} s {what}. Press Enter to begin.", nl=False)
            sys.stdin.readline()
            begin = (time.monotonic_ns() - traffic.start) / NS if traffic.frames else 0.0
            take(time.monotonic() + seconds)
            windows[name] = begin, begin + seconds
    finally:
        bus.shutdown()
    return traffic


@contextmanager
def _showing(now: Now | None) -> Iterator[Callable[[], None]]:
    if now is None:
        yield lambda: None
        return
    from rich.live import Live

    drawn = 0.0
    with Live(_drawn(now), console=printer(), auto_refresh=False, transient=True) as live:

        def draw() -> None:
            nonlocal drawn
            if time.monotonic() - drawn >= PICTURE_PERIOD_S:
                drawn = time.monotonic()
                live.update(_drawn(now), refresh=True)

        yield draw


def _drawn(now: Now) -> "Table":
    content = table("from", "what", "now", "unit")
    for source, name, value, unit in now.rows():
        content.add_row(source, name, "-" if math.isnan(value) else f"{value:.4g}", unit)
    return content
