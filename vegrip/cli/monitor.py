"""``vegrip monitor``: slip margins of running nodes, live."""

import json as json_format
import sys
import time
from contextlib import closing
from typing import Annotated

import typer

from vegrip.cli._options import OPENS, PORT
from vegrip.cli._terminal import announce_page, printer

STATUS_WAIT_S = 1.5  # [s] in which every node says how it is, at the usual period


def monitor(
    duration: Annotated[float, typer.Option(min=0.0, help="end after so many seconds; 0 = Ctrl-C")] = 0.0,
    once: Annotated[bool, typer.Option("--once", help="watch for a moment, print the table once")] = False,
    json: Annotated[bool, typer.Option("--json", help="watch for a moment, print one JSON object")] = False,
    web: Annotated[bool, typer.Option("--web", help="show it as a page in the browser")] = False,
    port: PORT = 8520,
    opens: OPENS = False,
) -> None:
    """Watch running nodes: per finger force, contact, margin with its bound, command and health.

    It reads the nodes' telemetry, so it works the same for CAN, ZeroMQ and the virtual bus. A number that is
    older than half a second is not shown; a node that is stopped, killed or has ended is called so. It is as
    wide as the terminal: from 118 columns on with contact radius, exponent, friction and ages. It waits for
    nodes, but with --once and --json, which are for scripts, says that none runs and ends. Into a file or a
    pipe go lines: what happens, and every second one for each finger.

    With --web the same and more is a page, on loopback: the limit surface with the load in it, the pressure
    over the contact, the last half minute, parameters and lifecycle. Its address, with a key, is printed; it
    waits for nodes.

    Example: vegrip monitor --web
    """
    if web:
        _serve(port, opens=opens)
        return
    from vegrip.runtime.monitor.board import Board, as_json
    from vegrip.runtime.monitor.table import render
    from vegrip.runtime.monitor.watch import Screen, Watch

    console = printer()
    with closing(Watch(waits=not (once or json))) as watch:  # complains before the screen opens
        if once or json:
            board = Board(time.monotonic_ns())
            watch.run(board, duration or STATUS_WAIT_S)
            now = time.monotonic_ns()
            board.refresh(now)
            if json:
                sys.stdout.write(json_format.dumps(as_json(board, now)) + "\n")
            else:
                console.print(render(board, now, "vegrip monitor", size=console.size))
            return
        if not console.is_terminal:
            console.print("a line a second for each finger, and what happens (--json: all of it, once)")
        screen = Screen("vegrip monitor (Ctrl-C ends)", console=console)
        screen.open()
        try:
            watch.run(screen, duration)
        finally:
            screen.close()


def _serve(port: int, *, opens: bool) -> None:
    from vegrip.web import require_web

    require_web()
    from vegrip.web.live.stream import run

    run(port, announce_page("live page"), opens=opens)
