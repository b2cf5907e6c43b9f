"""Lines and tables of text, as the terminal shows them."""

import io
from collections.abc import Container, Iterable, Sequence
from typing import Any

from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

WIDE_COLUMNS = 240  # columns
Part = str | Text | Table
"""A sentence or a table; the terminal fits it to its width."""


def figures(*header: str, left: Container[str] = ()) -> Table:
    """Return an empty table of numbers; the columns ``left`` are text."""
    columns = (Column(name, justify="left" if name in left else "right") for name in header)
    return Table(*columns, box=None, padding=(0, 2))


def table_of(header: Sequence[str], rows: Iterable[Sequence[str]], left: Container[str] = ()) -> Table:
    """Return a table with ``rows``."""
    table = figures(*header, left=left)
    for row in rows:
        table.add_row(*row)
    return table


def printable(text: str) -> str:
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


class Literal(Console):
    """Shows text as it stands, whatever file it comes from: no markup, no emoji and no control characters."""

    def __init__(self, **options: Any) -> None:
        super().__init__(highlight=False, markup=False, emoji=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        """Return ``text`` to be shown; sentences and the cells of tables come by here."""
        return super().render_str(printable(text), **options)


def plain(parts: Iterable[Part]) -> str:
    """Return ``parts`` as text, unbroken."""
    out = io.StringIO()
    console = Literal(
        file=out,
        soft_wrap=True,
        width=WIDE_COLUMNS,
        color_system=None,
        force_jupyter=False,
        force_terminal=False,
    )
    for part in parts:
        console.print(part)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines())


def first_rows(rows: Sequence[Any], most: int | None) -> tuple[Sequence[Any], list[str]]:
    """Return as many of ``rows`` as fit into ``most`` lines, and the line that says how many do not."""
    if most is None or len(rows) <= most:
        return rows, []
    shown = max(most - 1, 1)
    return rows[:shown], [f"  and {len(rows) - shown} more: .table() has all"]
