"""``vegrip bridge``: running hands in the programs of others."""

import asyncio
import ipaddress
import json
import math
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import group
from vegrip.cli._outputs import FORCE, claim_file
from vegrip.cli._terminal import complain
from vegrip.errors import UsageError

NICENESS = 10
"""Of what shows a hand: with three bridges beside it on two processors, 99 % of a node's commands took 4.9 ms
instead of 20 (``python -m benchmarks.page_cost --beside bridges``, *simulated*)."""

app = group(
    "Show running hands in the programs of others.\n\nExample: vegrip bridge foxglove --layout hand.json"
)


@app.command()
def foxglove(
    port: Annotated[int, typer.Option(min=0, max=65535, help="to listen on; 0 = any free one")] = 8765,
    host: Annotated[
        str, typer.Option(help="address to listen on; not loopback: the network may read")
    ] = "127.0.0.1",
    cdr: Annotated[bool, typer.Option("--cdr", help="send ROS 2 types in CDR, as PlotJuggler wants")] = False,
    newest: Annotated[bool, typer.Option("--newest", help="send the newest message of 40 ms alone")] = False,
    layout: Annotated[
        Path | None, typer.Option(help="write a layout for Foxglove, or FILE.xml for PlotJuggler, and end")
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
    from vegrip.bridges import require

    require("websockets", "the bridge to Foxglove", "foxglove")
    from vegrip.bridges.foxglove_channels import Cdr, Json
    from vegrip.bridges.foxglove_server import FoxgloveServer
    from vegrip.bridges.node_topics import NodeTopics

    _give_way()
    server = FoxgloveServer(NodeTopics(newest=newest), Cdr() if cdr else Json())

    def announce(found: int) -> None:
        if not _is_loopback(host):
            complain(f"every program that reaches {host} may read all topics and parameters, without a key")
        typer.echo(f"open ws://{host}:{found} in Foxglove or PlotJuggler; Ctrl-C ends")

    try:
        asyncio.run(server.run(host, port, announce))
    finally:
        server.close()
        if server.left_out:
            complain(f"{server.left_out} messages were left out for clients that read slowly")


@app.command()
def ros2(
    states: Annotated[
        str,
        typer.Option(
            help="ZeroMQ address at which the states that come are published, for a node to receive."
        ),
    ] = "",
    fingers: Annotated[str, typer.Option(help="Of which wrenches are read, by commas.")] = "thumb,index",
    namespace: Annotated[str, typer.Option(help="Before the topics that are read, such as /left.")] = "",
    domain: Annotated[int, typer.Option(min=0, max=232, help="ROS_DOMAIN_ID")] = 0,
    interface: Annotated[str, typer.Option(help='of the network; "" = any, and the network may send')] = "lo",
    multicast: Annotated[bool, typer.Option("--multicast", help="Find others by multicast.")] = False,
) -> None:
    """Speak ROS 2 without an installation of ROS: topics of running nodes out, wrenches of fingers in.

    Out: wrench_command of every finger, /diagnostics and vegrip_msgs of every topic. In, with --states:
    /hand/FINGER/wrench and /joint_states, to be received by a node whose transport is zmq.

    Example: vegrip bridge ros2 --states tcp://127.0.0.1:5701 --fingers thumb,index
    """
    from vegrip.bridges import require

    require("cyclonedds", "the bridge to ROS 2", "ros2")
    from vegrip.bridges.node_topics import NodeTopics
    from vegrip.bridges.ros2_dds import Incoming, Link, relay
    from vegrip.transport.open import Hand, open_endpoint

    names = tuple(name.strip() for name in fingers.split(",") if name.strip())
    if not names:
        raise UsageError(f"--fingers is {fingers!r}; give names by commas, such as thumb,index")
    link, source = Link(domain, interface, multicast, complain), NodeTopics()

    def announce() -> None:
        if interface != "lo":
            where = interface or "this machine"
            complain(f"every program that reaches {where} may read and send, without a key")
        typer.echo(f"domain {domain} on {interface or 'any interface'}; Ctrl-C ends")

    try:
        if not states:  # those that come in are commanded by: they do not wait
            _give_way()
            announce()
            with _interrupts() as is_over:
                relay(link, source, is_over=is_over)
        else:
            hand = Hand(names, namespace=namespace)
            address = {"kind": "zmq", "publish": states}
            with open_endpoint(address, hand, "--states") as endpoint, _interrupts() as is_over:
                announce()
                relay(link, source, Incoming(link, names, namespace), endpoint.send, is_over)
    finally:
        source.rest()
        if link.left_out:
            complain(f"{link.left_out} messages were left out: of second publishers, or for slow readers")


@app.command()
def mcap(
    output: Annotated[
        Path, typer.Option("-o", "--output", help="MCAP file to write; not one that is there.")
    ],
    duration: Annotated[float, typer.Option(min=0.0, help="in s; 0 = until Ctrl-C")] = 0.0,
    force: FORCE = False,
) -> None:
    """Write what running nodes say to an MCAP file of ROS 2 types, which stays readable if this is killed.

    Example: vegrip bridge mcap -o grasp.mcap --duration 60
    """
    from vegrip.bridges.node_topics import NodeTopics
    from vegrip.bridges.ros2_mcap import record_ros2_mcap
    from vegrip.whole_file import writing

    claim_file(output, force=force)
    _give_way()
    source, count = NodeTopics(), 0
    try:
        with writing(output):
            for count in record_ros2_mcap(output, source, time.monotonic() + (duration or math.inf)):  # noqa: B007
                pass
    finally:
        source.rest()
        typer.echo(f"{output}: {count} messages")


@contextmanager
def _interrupts() -> Iterator[Callable[[], bool]]:
    """Yield whether Ctrl-C was pressed; raised within Cyclone DDS it would come out as another error."""
    pressed: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt


def _give_way() -> None:
    """Leave the processor to nodes that want it; what only shows may be late."""
    if hasattr(os, "nice"):  # Windows has none
        os.nice(NICENESS)


def _write_layout(path: Path) -> None:
    from vegrip.bridges.foxglove_layout import layout
    from vegrip.bridges.plotjuggler_layout import plotjuggler_layout
    from vegrip.errors import InputError
    from vegrip.messages import USUAL_FINGERS
    from vegrip.runtime.registry import running_nodes
    from vegrip.whole_file import write_whole, writing

    hands: dict[str, dict[str, None]] = {}
    for entry in running_nodes():
        hands.setdefault(entry.namespace, {}).update(dict.fromkeys(entry.fingers))
    fingers = {namespace: tuple(names) for namespace, names in hands.items() if names} or {"": USUAL_FINGERS}
    is_xml = path.suffix.lower() == ".xml"
    text = plotjuggler_layout(fingers) if is_xml else json.dumps(layout(fingers), indent=2) + "\n"
    with writing(path, InputError):
        write_whole(path, text)
    where = "PlotJuggler: load layout" if is_xml else "Foxglove: layouts, import from file"
    typer.echo(f"{path}: {sum(map(len, fingers.values()))} fingers; in {where}")


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
