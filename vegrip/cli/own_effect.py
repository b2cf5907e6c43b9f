"""``vegrip new-effect`` and ``vegrip test-effect``: an effect of one's own, and its laws."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, require_writable
from vegrip.cli._terminal import print_json, printer
from vegrip.errors import UsageError

NAMES = Annotated[
    list[str] | None,
    typer.Argument(help="Effects to test; by default all that other packages have added."),
]
EXIT_BROKEN_LAW = 3  # exit code: an effect that breaks a law is bad input


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
    from vegrip.effects.scaffold import write_package

    folder = output or Path(name)
    require_writable(folder)
    written = write_package(name, folder, replace=force)
    if as_json:
        print_json({"files": [str(path) for path in written]})
        return
    console = printer()
    for path in written:
        console.print(str(path))
    console.print(
        f"\nWrite your law into {written[1]}, then: pip install -e {folder} && python -m pytest {folder}"
    )


def effect_laws(
    effects: NAMES = None,
    as_json: JSON = False,
) -> None:
    """Test whether effects hold to the laws that every effect of vegrip holds to.

    An effect must be absent at its null values and felt at its defaults, converge with shorter steps, stay
    finite at its bounds, and be the same compiled and uncompiled. Exit code 3 when one breaks a law.

    Example: vegrip test-effect adhesion
    """
    from vegrip.effects import BUILT_IN, effect, names
    from vegrip.model.laws import LAWS, broken_laws

    chosen = effects or [name for name in names() if name not in BUILT_IN]
    if not chosen:
        raise UsageError(
            "no other package has added an effect; give the name of one, or write one: vegrip new-effect NAME"
        )
    found = [effect(name) for name in chosen]  # a wrong name is reported before the work
    broken = {}
    for name, one in zip(chosen, found, strict=True):
        broken[name] = broken_laws(one)
        if not as_json:
            said = f"breaks {len(broken[name])} of" if broken[name] else "holds to"
            typer.echo(f"{name}: {said} {len(LAWS)} laws")
            for sentence in broken[name]:
                typer.echo(f"  {sentence}")
    if as_json:
        print_json({name: {"broken": sentences} for name, sentences in broken.items()})
    if any(broken.values()):
        raise typer.Exit(EXIT_BROKEN_LAW)
