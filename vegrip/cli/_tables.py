"""What the command line prints: sentences and tables, as wide as the terminal, wide and unbroken in a file.

Nothing here reads markup: ``[m]`` is a unit, not a tag.
"""

from rich.console import Console
from rich.table import Column, Table

WIDE = 240  # columns


def table(*header: str, wraps: str = "") -> Table:
    """Return an empty table; only the column ``wraps`` breaks its lines."""
    return Table(*(Column(name, no_wrap=name != wraps) for name in header), box=None, pad_edge=False)


def printer(*, stderr: bool = False) -> Console:
    """Return where sentences go: broken between words in a terminal, unbroken in a file."""
    console = Console(highlight=False, markup=False, stderr=stderr)
    if console.is_terminal:
        return console
    return Console(highlight=False, markup=False, soft_wrap=True, width=WIDE, stderr=stderr)


def show(content: Table) -> None:
    """Print ``content``."""
    console = Console(markup=False)
    (console if console.is_terminal else Console(markup=False, width=WIDE)).print(content)


def complain(sentence: str) -> None:
    """Print one sentence on standard error, in red."""
    Console(stderr=True, highlight=False, markup=False).print(
        f"vegrip: {sentence}", style="red", soft_wrap=True
    )
