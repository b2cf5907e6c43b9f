"""All commands of the program, with their subcommands, as the tests of its laws walk over them."""

from dataclasses import dataclass
from typing import Any

from typer.main import get_command

from vegrip import cli


@dataclass(frozen=True)
class Command:
    """One command: what is typed, what runs, and what its author wrote of its options."""

    path: tuple[str, ...]
    click: Any  # as typer makes it: params, help

    @property
    def name(self) -> str:
        return " ".join(self.path)

    @property
    def options(self) -> set[str]:
        return {option for each in self.click.params for option in each.opts}


def commands() -> list[Command]:
    """Every command that runs something; of a group its subcommands."""
    found = []
    for name in cli.COMMANDS:
        top = get_command(cli.load(name))
        subs = getattr(top, "commands", None)
        if subs:
            found += [Command((name, sub), click) for sub, click in subs.items()]
        else:
            found.append(Command((name,), top))
    return found
