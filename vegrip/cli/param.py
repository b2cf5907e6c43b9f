"""``vegrip param``: parameters of running nodes."""

from typing import Annotated, Any

import typer

from vegrip.cli._options import JSON, NODE_NAME, group
from vegrip.cli._terminal import answer, print_json, show, table
from vegrip.errors import UsageError, suggestion

app = group(
    "Read and set parameters of running nodes.\n\n"
    "Example: vegrip param set grasp_force grip.wanted_margin 0.4"
)


@app.command("list")
def list_(node: NODE_NAME, as_json: JSON = False) -> None:
    """List the parameters of a node with value, unit, bounds and meaning.

    Example: vegrip param list grasp_force

    """
    rows = _ask(node, "parameters")
    if as_json:
        print_json({row["name"]: row for row in rows})
        return
    content = table("parameter", "value", "unit", "bounds", "meaning", wraps="meaning")
    for row in rows:
        fixed = "" if row["live"] else " (fixed while running)"
        content.add_row(row["name"], str(row["value"]), row["unit"], _bounds(row), row["doc"] + fixed)
    show(content)


@app.command()
def get(
    node: NODE_NAME, name: Annotated[str, typer.Argument(help="Parameter.")], as_json: JSON = False
) -> None:
    """Print the value of one parameter.

    Example: vegrip param get grasp_force grip.wanted_margin

    """
    _show(_ask(node, "parameters"), node, name, as_json)


@app.command("set", context_settings={"ignore_unknown_options": True})  # a value may be -1
def set_(
    node: NODE_NAME,
    name: Annotated[str, typer.Argument(help="Parameter.")],
    value: Annotated[str, typer.Argument(help="New value, written as in TOML.")],
    as_json: JSON = False,
) -> None:
    """Set one parameter; refused outside its bounds.

    Example: vegrip param set grasp_force grip.wanted_margin 0.4

    """
    from vegrip.cli.node import parsed

    _show(_ask(node, "set_parameter", name=name, value=parsed(value)), node, name, as_json)


def _show(rows: list[dict[str, Any]], node: str, name: str, as_json: bool) -> None:

    found = {row["name"]: row for row in rows}
    if name not in found:
        raise UsageError(f"{node}: there is no parameter {name!r}; {suggestion(name, found, 'it has')}")
    row = found[name]
    unit = "" if row["unit"] == "1" else row["unit"]
    answer(row, lambda: typer.echo(f"{row['value']} {unit}".rstrip()), as_json=as_json)


def _bounds(row: dict[str, Any]) -> str:
    if row["choices"]:
        return " | ".join(row["choices"])
    low, high = row["low"], row["high"]
    return "" if (low, high) == (-float("inf"), float("inf")) else f"{low:g} .. {high:g}"


def _ask(node: str, call: str, **arguments: Any) -> Any:
    from vegrip.runtime.registry import ask, find_node

    return ask(find_node(node), call, **arguments)
