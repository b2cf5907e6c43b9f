"""``vegrip lifecycle``: states of running nodes."""

from typing import Annotated, Any

import typer

from vegrip.cli._options import JSON, NODE_NAME, group
from vegrip.cli._terminal import answer, print_json, show, table
from vegrip.errors import DeviceError, UsageError
from vegrip.jsonable import jsonable

app = group(
    "Read and change the state of running nodes.\n\nExample: vegrip lifecycle set grasp_force inactive"
)


@app.command("list")
def list_(as_json: JSON = False) -> None:
    """List the running nodes and their states, and those that could not be started, with the reason.

    Example: vegrip lifecycle list

    """
    from vegrip.runtime.registry import read_reports, running_nodes

    nodes = {name: _ended(words) for name, words in read_reports().items()}
    nodes |= {
        entry.name: {"program": entry.program, "pid": entry.pid, **_state(entry)} for entry in running_nodes()
    }
    if as_json:
        print_json(nodes)
        return
    if not nodes:
        typer.echo("no node runs; try: vegrip launch demo")
        return
    content = table("node", "program", "process", "state", "can, or why not", wraps="can, or why not")
    for name, row in sorted(nodes.items()):
        held = " (on hold)" if row["on_hold"] else ""
        can = row.get("reason") or ", ".join(row["transitions"])
        content.add_row(name, row["program"], str(row["pid"] or "-"), row["state"] + held, can)
    show(content)


@app.command()
def get(node: NODE_NAME, as_json: JSON = False) -> None:
    """Print the state of a node.

    Example: vegrip lifecycle get grasp_force

    """
    _show(_ask_or_recall(node, "state"), as_json)


@app.command()
def status(node: NODE_NAME, as_json: JSON = False) -> None:
    """Print how a node is doing: its last NodeStatus, and the hand's clock where it is estimated.

    Example: vegrip lifecycle status grasp_force

    """
    result = jsonable(_ask_or_recall(node, "status"), says_infinity=True)
    lines = "\n".join(f"{name}: {value}" for name, value in (result or {}).items())
    answer(result, lambda: typer.echo(lines), as_json=as_json)


@app.command("set")
def set_(
    node: NODE_NAME,
    target: Annotated[
        str,
        typer.Argument(help="unconfigured, inactive, active, finalized, or a transition such as activate."),
    ],
    as_json: JSON = False,
) -> None:
    """Bring a node to a state, by way of others if need be.

    Example: vegrip lifecycle set grasp_force inactive

    """
    from vegrip.runtime.registry import CONFIGURING_MAY_TAKE, ask, find_node

    _show(ask(find_node(node), "set_state", patience=CONFIGURING_MAY_TAKE, target=target), as_json)


def zero(node: NODE_NAME, as_json: JSON = False) -> None:
    """Have the sensors of a hand take their own zeros, by the command that its map has for that.

    The node must be inactive: what it may hold would weigh nothing afterwards.

    Example: vegrip lifecycle set grasp_force inactive && vegrip zero grasp_force

    """
    from vegrip.runtime.registry import ask, find_node

    ask(find_node(node), "zero")
    answer({"zero": "asked for"}, lambda: typer.echo("zero: asked for"), as_json=as_json)


def _ask_or_recall(node: str, call: str) -> Any:
    from vegrip.runtime.registry import ask, find_node, read_reports

    try:
        found = find_node(node)
    except UsageError:
        ends = [words for name, words in read_reports().items() if name == node or name.endswith(f"/{node}")]
        if len(ends) != 1:
            raise
        return {"node": ends[0].name, **_ended(ends[0])}
    return ask(found, call)


def _ended(words: Any) -> dict[str, Any]:
    return {
        "program": words.program,
        "pid": 0,
        "state": "finalized",
        "on_hold": False,
        "transitions": [],
        "reason": words.reason,
        "exit_code": words.exit_code,
    }


def _show(state: dict[str, Any], as_json: bool) -> None:
    held = " (on hold)" if state["on_hold"] else ""
    reason = f": {state['reason']}" if "reason" in state else ""
    answer(state, lambda: typer.echo(state["state"] + held + reason), as_json=as_json)


def _state(entry: Any) -> dict[str, Any]:
    from vegrip.runtime.registry import ask, silent_state

    try:
        state: dict[str, Any] = ask(entry, "state", patience=1.0)
    except DeviceError:
        return {"state": silent_state(entry.pid), "on_hold": False, "transitions": []}
    return state
