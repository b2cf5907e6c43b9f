"""``vegrip launch``: the nodes of a launch file as processes."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from vegrip.cli._terminal import show, table
from vegrip.clock import WallClock
from vegrip.errors import VegripError
from vegrip.host.realtime import NODE_PRIORITY, choose_scheduling, is_switched_on, permission, switched

if TYPE_CHECKING:
    from vegrip.runtime.launcher import Sayings

COLOURS = ("cyan", "green", "magenta", "yellow", "blue", "bright_red")


def launch(
    file: Annotated[
        str, typer.Argument(help="Launch file, or one of vegrip's own: demo, zmq, vcan, can0, canopen.")
    ],
    check: Annotated[
        bool,
        typer.Option("--check", help="Read the file, check the parameters, show the nodes, start nothing."),
    ] = False,
    realtime: Annotated[
        bool, typer.Option(help="Real-time priority and locked memory, where they are permitted.")
    ] = True,
) -> None:
    """Start the nodes of a launch file, show their logs, restart them as configured, stop them in order.

    Ends with Ctrl-C, when all nodes have ended, or when one that is required has.

    Example: vegrip launch demo

    """
    from vegrip.runtime.launch_file import find_launch_file, read_launch_file
    from vegrip.runtime.node import NodeContext, find_program

    path = find_launch_file(file)
    nodes = read_launch_file(path)
    for node in nodes:
        build = find_program(node.program)
        if check:
            build(node.parameters, NodeContext(node.full_name, node.namespace, node.fingers))
    if check:
        _show(nodes)
        return

    wanted = realtime and any(node.realtime for node in nodes)
    with switched(on=wanted and _is_permitted()):
        code = _run(path, nodes)
    raise typer.Exit(code)


def _is_permitted() -> bool:
    """Whether the nodes may have real-time priority; said here once, not by each of them."""
    chosen = choose_scheduling(NODE_PRIORITY, permission(), on=is_switched_on())
    if chosen.sentence:
        Console(highlight=False, markup=False, soft_wrap=True).print(chosen.sentence)
    return chosen.priority > 0


def _run(path: Path, nodes: list[Any]) -> int:
    from vegrip.runtime.launcher import ChildProcess, Launcher, Sayings

    width = max(len(node.full_name) for node in nodes)
    readers: list[threading.Thread] = []
    children = []
    consoles = {}
    for index, node in enumerate(nodes):
        say = consoles[node.full_name] = _Prefix(node.full_name, width, COLOURS[index % len(COLOURS)])
        sayings = Sayings()
        start = _starter(path, node.full_name, partial(_say_new, sayings, say), readers)
        ready = partial(_is_active, node.full_name) if node.wait else None
        children.append(ChildProcess(node.full_name, start, node.restart, node.required, ready, sayings))
    launcher = Launcher(children, WallClock(), lambda name, sentence: consoles[name](f"-- {sentence}"))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: launcher.stop())
    code = launcher.run()
    for reader in readers:
        reader.join(timeout=1.0)
    return code


def _is_active(name: str) -> bool:
    from vegrip.runtime.registry import ask, find_node

    try:
        state: str = ask(find_node(name), "state", patience=0.2)["state"]
    except VegripError:  # not there yet, or busy compiling
        return False
    return state == "active"


class _Prefix:
    def __init__(self, name: str, width: int, colour: str) -> None:
        self._prefix = Text(f"{name:<{width}} | ", style=colour)
        self._console = Console(highlight=False, markup=False, soft_wrap=True)

    def __call__(self, line: str) -> None:
        self._console.print(self._prefix + Text(line))


def _say_new(sayings: "Sayings", say: _Prefix, line: str) -> None:
    if sayings.is_new(line):
        say(line)


def _starter(
    path: Path, name: str, say: Callable[[str], None], readers: list[threading.Thread]
) -> Callable[[], subprocess.Popen[str]]:
    command = [sys.executable, "-m", "vegrip", "node", name, "--config", str(path)]
    command += ["--with-parent", str(os.getpid())]

    def start() -> subprocess.Popen[str]:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            process_group=0,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )
        reader = threading.Thread(target=_forward, args=(process, say), daemon=True)
        reader.start()
        readers.append(reader)
        return process

    return start


def _forward(process: subprocess.Popen[str], say: Callable[[str], None]) -> None:
    if process.stdout is not None:
        with process.stdout as lines:
            for line in lines:
                say(line.rstrip("\n"))


def _show(nodes: list[Any]) -> None:
    content = table("node", "program", "transport", "restart", "required")
    for node in nodes:
        kind = node.transport.get("kind", "can")
        required = "yes" if node.required else ""
        content.add_row(node.full_name, node.program, kind, node.restart, required)
    show(content)
