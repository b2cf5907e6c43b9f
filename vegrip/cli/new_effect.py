"""``vegrip new-effect``: a package for an effect of one's own."""

from pathlib import Path
from typing import Annotated

import typer


def new_effect(
    name: Annotated[str, typer.Argument(help="Name of the effect, as in lateral_give.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write to; by default ./NAME.")
    ] = None,
) -> None:
    """Write a package that adds an effect of your own; it works at once and is yours to change.

    Example: vegrip new-effect lateral_give && pip install -e ./lateral_give && vegrip diagnose press
    """
    from rich.console import Console

    from vegrip.effects.scaffold import write_package

    folder = output or Path(name)
    written = write_package(name, folder)
    console = Console(highlight=False, soft_wrap=True)
    for path in written:
        console.print(str(path))
    console.print(
        f"\nWrite your law into {written[1]}, then: pip install -e {folder} && python -m pytest {folder}"
    )
