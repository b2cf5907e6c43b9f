"""``vegrip monitor``: slip margins of running nodes, live."""

import json as json_format
import sys
import time
from typing import Annotated

import typer


def monitor(
    duration: Annotated[float, typer.Option(min=0.0, help="end after so many seconds; 0 = Ctrl-C")] = 0.0,
    json: Annotated[bool, typer.Option("--json", help="watch for a second, print one JSON object")] = False,
) -> None:
    """Watch running nodes: per finger force, contact, margin with its bound, command and health.

    It reads the nodes' telemetry, so it works the same for CAN, ZeroMQ and the virtual bus.

    Example: vegrip monitor
    """
    from vegrip.monitor.board import Board, as_json
    from vegrip.monitor.screen import Screen
    from vegrip.monitor.watch import watch

    if json:
        board = Board(time.monotonic_ns())
        for message in watch(duration or 1.0):
            if message is not None:
                board.take(message, time.monotonic_ns())
        sys.stdout.write(json_format.dumps(as_json(board)) + "\n")
        return
    screen = Screen("vegrip monitor (Ctrl-C ends)")
    messages = watch(duration)
    first = next(messages)  # complains before the screen opens
    screen.open()
    try:
        if first is not None:
            screen.offer(first, time.monotonic_ns())
        for message in messages:
            if message is not None:
                screen.offer(message, time.monotonic_ns())
    finally:
        screen.close()
