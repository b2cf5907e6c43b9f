"""``vegrip bridge``: running hands in the programs of others."""

import asyncio
import ipaddress
import json
from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import group
from vegrip.cli._terminal import complain

app = group(
    "Show running hands in the programs of others.\n\nExample: vegrip bridge foxglove --layout hand.json"
)


@app.callback()
def bridge() -> None:
    """Keep the name of the bridge in the command while there is one alone."""


@app.command()
def foxglove(
    port: Annotated[int, typer.Option(min=0, max=65535, help="to listen on; 0 = any free one")] = 8765,
    host: Annotated[
        str, typer.Option(help="address to listen on; not loopback: the network may read")
    ] = "127.0.0.1",
    cdr: Annotated[bool, typer.Option("--cdr", help="send ROS 2 types in CDR, as PlotJuggler wants")] = False,
    newest: Annotated[bool, typer.Option("--newest", help="send the newest message of 40 ms alone")] = False,
    layout: Annotated[
        Path | None, typer.Option(help="write a layout for Foxglove to this file, and end")
    ] = None,
) -> None:
    """Serve every topic of running nodes to Foxglove and PlotJuggler, over WebSocket.

    Each topic is a typed channel whose schema states the units; alarms are a log on /vegrip/alarms, and the
    parameters of nodes can be read. Only what a client shows is asked of a node. It waits for nodes.

    Example: vegrip bridge foxglove --layout hand.json
    """
    if layout is not None:
        _write_layout(layout)
        return
    from vegrip.bridges import require_websockets

    require_websockets()
    from vegrip.bridges.foxglove_channels import Cdr, Json
    from vegrip.bridges.foxglove_server import FoxgloveServer
    from vegrip.bridges.node_topics import NodeTopics

    if not _is_loopback(host):
        complain(f"every program that reaches {host} may read all topics and parameters, without a key")
    server = FoxgloveServer(NodeTopics(newest=newest), Cdr() if cdr else Json())

    def announce(found: int) -> None:
        typer.echo(f"open ws://{host}:{found} in Foxglove or PlotJuggler; Ctrl-C ends")

    try:
        asyncio.run(server.run(host, port, announce))
    finally:
        server.close()
        if server.left_out:
            complain(f"{server.left_out} messages were left out for clients that read slowly")


def _write_layout(path: Path) -> None:
    from vegrip.bridges.foxglove_layout import FINGERS, layout
    from vegrip.errors import InputError
    from vegrip.runtime.registry import running_nodes
    from vegrip.whole_file import write_whole, writing

    hands: dict[str, dict[str, None]] = {}
    for entry in running_nodes():
        hands.setdefault(entry.namespace, {}).update(dict.fromkeys(entry.fingers))
    fingers = {namespace: tuple(names) for namespace, names in hands.items() if names} or {"": FINGERS}
    with writing(path, InputError):
        write_whole(path, json.dumps(layout(fingers), indent=2) + "\n")
    count = sum(map(len, fingers.values()))
    typer.echo(f"{path}: {count} fingers; in Foxglove: layouts, import from file")


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
