"""``vegrip connect --list`` and ``--hand``: the maps in the box."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from vegrip.errors import ConfigError, InputError, UsageError
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from vegrip.transport.mapped.drafts import Setting

SHORT = {
    "normal_force": "normal",
    "tangential_force_x": "tangential",
    "tangential_force_y": "tangential",
    "torque_z": "torque",
}


def show_all(*, as_json: bool) -> None:
    """Print what there is, and how far each is verified."""
    from vegrip.cli._terminal import show, table
    from vegrip.transport.mapped.products import about, names

    found = [about(name) for name in names()]
    if as_json:
        typer.echo(json.dumps(found))
        return
    content = table("hand", "carrier", "channels", "commands", "to measure", "checked against", "tried on")
    for one in found:
        content.add_row(
            one["hand"],
            one["carrier"],
            ", ".join(dict.fromkeys(SHORT.get(each, each) for each in one["channels"])),
            one["commands"] or "-",
            f"{len(one['to_measure'])} values" if one["to_measure"] else "-",
            one["checked_against"].partition(" at ")[0] or "its source alone",
            ", ".join(one["tried_on"]) or "-",
        )
    show(content)


def write(
    name: str,
    output: Path | None,
    settings: "list[Setting]",
    address: str,
    channel: str,
    *,
    force: bool,
    as_json: bool,
) -> None:
    """Write the map of a product, with what is said of it, and tell what is still to be measured."""
    from vegrip.config import parse_toml
    from vegrip.transport.mapped.plan import make_plan, read_database
    from vegrip.transport.mapped.price import price
    from vegrip.transport.mapped.products import map_of
    from vegrip.transport.mapped.schema import parse_map
    from vegrip.transport.mapped.writer import changed_text

    text = map_of(name).read_text(encoding="utf-8")
    kind = parse_toml(text)["transport"]["kind"]
    if address and kind == "can":
        raise UsageError(f"{name} is on a CAN bus; give --channel")
    if channel and kind != "can":
        raise UsageError(f"{name} is no CAN device; give --address")
    where = [(["transport", "address"], address)] * bool(address)
    where += [(["transport", "channel"], channel)] * bool(channel)
    text = changed_text(text, where + settings)
    target = output or Path(f"{name}.toml")
    sentences, is_ready = [], True
    try:
        hand = parse_map(parse_toml(text), target)
        sentences = price(make_plan(hand, read_database(hand), tuple(hand.fingers)))
    except ConfigError as error:
        if "is not known" not in str(error):
            raise
        sentences, is_ready = [str(error)], False
    if output is not None:
        _put(output, text, force=force)
    _tell(text, output, sentences, is_ready=is_ready, as_json=as_json)


def _put(output: Path, text: str, *, force: bool) -> None:
    if output.exists() and not force:
        raise InputError(f"{output}: is there already; give another name, or --force to replace it")
    if not output.parent.is_dir():
        raise InputError(f"{output.parent}: there is no such folder")
    try:
        write_whole(output, text)
    except OSError as error:
        raise InputError(f"{output} cannot be written: {error.strerror or error}") from None


def _tell(text: str, output: Path | None, sentences: list[str], *, is_ready: bool, as_json: bool) -> None:
    told: dict[str, Any] = {"map": str(output) if output else None, "ready": is_ready, "price": sentences}
    if as_json:
        typer.echo(json.dumps(told))
        return
    if output is None:
        typer.echo(text)
    for sentence in sentences:
        typer.echo(f"{'price' if is_ready else 'measure'}: {sentence}")
    if output is not None:
        next_ = (
            f"vegrip launch {output.stem} --check"
            if is_ready
            else f"vegrip connect {output}, when it is known"
        )
        typer.echo(f"written: {output}; next: {next_}")
