"""``vegrip monitor``: slip margins of running nodes, live."""

import json as json_format
import sys
import time
from contextlib import closing
from typing import Annotated

import typer

ENOUGH = 1.5  # [s] in which every node says how it is, at the usual period


def monitor(
    duration: Annotated[float, typer.Option(min=0.0, help="end after so many seconds; 0 = Ctrl-C")] = 0.0,
    json: Annotated[bool, typer.Option("--json", help="watch for a moment, print one JSON object")] = False,
) -> None:
    """Watch running nodes: per finger force, contact, margin with its bound, command and health.

    It reads the nodes' telemetry, so it works the same for CAN, ZeroMQ and the virtual bus. A number that is
    older than half a second is not shown; a node that is stopped, killed or has ended is called so. It is as
    wide as the terminal: from 118 columns on with contact radius, exponent, friction and ages.

    Example: vegrip monitor
    """
    from vegrip.runtime.monitor.board import Board, as_json
    from vegrip.runtime.monitor.screen import Screen
    from vegrip.runtime.monitor.watch import Watch

    with closing(Watch()) as watch:  # complains before the screen opens
        if json:
            board = Board(time.monotonic_ns())
            watch.run(board, duration or ENOUGH)
            now = time.monotonic_ns()
            board.look(now)
            sys.stdout.write(json_format.dumps(as_json(board, now)) + "\n")
            return
        screen = Screen("vegrip monitor (Ctrl-C ends)")
        screen.open()
        try:
            watch.run(screen, duration)
        finally:
            screen.close()
