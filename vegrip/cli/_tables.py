"""Tables of the command line: as wide as the terminal, wide and unbroken in a file."""

from rich.console import Console
from rich.table import Column, Table

WIDE = 240  # columns


def table(*header: str, wraps: str = "") -> Table:
    """Return an empty table; only the column ``wraps`` breaks its lines."""
    return Table(*(Column(name, no_wrap=name != wraps) for name in header), box=None, pad_edge=False)


def printable(text: str) -> str:
    """Return ``text``, which may name what a file holds, without control characters for the terminal."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def printer() -> Console:
    """Return where sentences go: broken between words in a terminal, unbroken in a file."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, soft_wrap=True, width=WIDE)


def show(content: Table) -> None:
    """Print ``content``."""
    console = Console()
    (console if console.is_terminal else Console(width=WIDE)).print(content)
