"""What the command line prints: sentences and tables, as wide as the terminal, wide and unbroken in a file.

Nothing here reads markup: ``[m]`` is a unit, not a tag.
"""

import shlex
from typing import Any

from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

WIDE_COLUMNS = 240  # columns


def table(*header: str, wraps: str = "") -> Table:
    """Return an empty table; only the column ``wraps`` breaks its lines."""
    return Table(*(Column(name, no_wrap=name != wraps) for name in header), box=None, pad_edge=False)


def printable(text: str) -> str:
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


class _Literal(Console):
    """Shows text as it stands, whatever file it comes from: no markup, no emoji and no control characters."""

    def __init__(self, **options: Any) -> None:
        super().__init__(highlight=False, markup=False, emoji=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        """Return ``text`` to be shown; sentences and the cells of tables come by here."""
        return super().render_str(printable(text), **options)


def printer(*, stderr: bool = False) -> Console:
    """Return where sentences go: broken between words in a terminal, unbroken in a file."""
    console = _Literal(stderr=stderr)
    return console if console.is_terminal else _Literal(soft_wrap=True, width=WIDE_COLUMNS, stderr=stderr)


def show(content: Table) -> None:
    console = _Literal()
    (console if console.is_terminal else _Literal(width=WIDE_COLUMNS)).print(content)


def print_next(*words: object) -> None:
    printer().print(f"next: {shlex.join(map(str, words))}", soft_wrap=True)


def complain(sentence: str) -> None:
    _Literal(stderr=True).print(f"vegrip: {sentence}", style="red", soft_wrap=True)
