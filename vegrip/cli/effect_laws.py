"""``vegrip test-effect``: the laws of every effect, asked of one's own."""

import json
from typing import Annotated

import typer

from vegrip.cli._options import JSON

NAMES = Annotated[
    list[str] | None,
    typer.Argument(help="Effects to test; by default all that other packages have added."),
]
EXIT_BROKEN_LAW = 3  # exit code: an effect that breaks a law is bad input


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
    from vegrip.errors import UsageError
    from vegrip.model.laws import LAWS, broken_laws

    chosen = effects or [name for name in names() if name not in BUILT_IN]
    if not chosen:
        raise UsageError(
            "no other package has added an effect; give the name of one, or write one: vegrip new-effect NAME"
        )
    found = [effect(name) for name in chosen]  # a wrong name is told before the work
    broken = {}
    for name, one in zip(chosen, found, strict=True):
        broken[name] = broken_laws(one)
        if not as_json:
            _tell(name, broken[name], len(LAWS))
    if as_json:
        typer.echo(json.dumps({name: {"broken": sentences} for name, sentences in broken.items()}))
    if any(broken.values()):
        raise typer.Exit(EXIT_BROKEN_LAW)


def _tell(name: str, broken: list[str], laws: int) -> None:
    typer.echo(f"{name}: breaks {len(broken)} of {laws} laws" if broken else f"{name}: holds to {laws} laws")
    for sentence in broken:
        typer.echo(f"  {sentence}")
