"""``vegrip new-effect``: a package for an effect of one's own."""

import json
from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, require_writable


def new_effect(
    name: Annotated[str, typer.Argument(help="Name of the effect, as in lateral_give.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write to; by default ./NAME.")
    ] = None,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Write a package that adds an effect of your own; it works at once and is yours to change.

    Example: vegrip new-effect lateral_give
    """
    from vegrip.cli._tables import printer
    from vegrip.effects.scaffold import write_package

    folder = output or Path(name)
    require_writable(folder)
    written = write_package(name, folder, replace=force)
    if as_json:
        typer.echo(json.dumps({"files": [str(path) for path in written]}))
        return
    console = printer()
    for path in written:
        console.print(str(path))
    console.print(
        f"\nWrite your law into {written[1]}, then: pip install -e {folder} && python -m pytest {folder}"
    )
