"""``vegrip node``: one node in this process."""

import dataclasses
from pathlib import Path
from typing import Annotated, Any

import typer

from vegrip.config import build, parse_toml
from vegrip.errors import UsageError, suggestion


def node(
    name: Annotated[
        str, typer.Argument(help="Program, or name of a node in the launch file given with --config.")
    ],
    config: Annotated[
        Path | None, typer.Option(help="Launch file to take the node's configuration from.")
    ] = None,
    namespace: Annotated[str | None, typer.Option(help="In front of names and topics, e.g. left.")] = None,
    as_name: Annotated[str | None, typer.Option("--name", help="Name of the node.")] = None,
    values: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE over the configuration; may be repeated.")
    ] = None,
    autostart: Annotated[bool, typer.Option(help="Configure and activate at once.")] = True,
    with_parent: Annotated[int | None, typer.Option("--with-parent", hidden=True)] = None,
) -> None:
    """Run one node until it has finished or is interrupted.

    The programs are grasp_force, virtual_hand, record, replay, monitor, echo, those of other packages
    (entry points of the group vegrip.programs), and module:function.

    Example: vegrip node virtual_hand --config demo --set parameters.seed=3

    On a bus of yours: vegrip node grasp_force --set transport.interface=socketcan
    --set transport.channel=can0

    """
    from vegrip.runtime.launcher import end_with_parent
    from vegrip.runtime.process import run_node

    if with_parent is not None:
        end_with_parent(with_parent)
    run_node(configured(name, config, namespace, as_name, values or []), autostart)


def configured(
    name: str, config: Path | None, namespace: str | None, as_name: str | None, values: list[str]
) -> Any:
    """Return the configuration of a node: that of the launch file, then what the command line says."""
    from vegrip.runtime.launch_file import NodeConfig, with_map
    from vegrip.runtime.node import find_program

    base = _from_file(config, name) if config is not None else NodeConfig(program=name)
    table = {f.name: getattr(base, f.name) for f in dataclasses.fields(base)}
    table["loop"] = dataclasses.asdict(base.loop)
    table |= {key: value for key, value in (("namespace", namespace), ("name", as_name)) if value is not None}
    before = base.transport.get("map")
    for assignment in values:
        assigned(table, assignment)
    find_program(table["program"])
    made = build(NodeConfig, table, f"node {name}")
    return with_map(Path(), made) if made.transport.get("map") != before else made


def _from_file(config: Path, name: str) -> Any:
    from vegrip.runtime.launch_file import find_launch_file, read_launch_file

    nodes = read_launch_file(find_launch_file(str(config)))
    for candidate in nodes:
        if candidate.full_name in (name, f"/{name}"):
            return candidate
    known = suggestion(name, [candidate.full_name for candidate in nodes], "it has")
    raise UsageError(f"{config}: there is no node {name!r}; {known}")


def parsed(text: str) -> Any:
    """Return the value of ``text``: 0.4, 3, true, [1, 2], "text" or text."""
    try:
        return parse_toml(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def assigned(table: dict[str, Any], assignment: str) -> None:
    key, equals, value = assignment.partition("=")
    if not (equals and key):
        raise UsageError(f"{assignment!r} is no assignment; write --set transport.channel=can1")
    *groups, last = key.split(".")
    for group in groups:
        table = table.setdefault(group, {})
        if not isinstance(table, dict):
            raise UsageError(f"{group!r} in {key!r} is a value, not a table")
    table[last] = parsed(value)
