"""What the command line prints: sentences, tables, JSON, and the progress of long work on standard error.

As wide as the terminal, wide and unbroken in a file. Nothing here reads markup: ``[m]`` is a unit, not a tag.
"""

import json
import shlex
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.table import Column, Table

from vegrip.display.text import WIDE_COLUMNS, Literal
from vegrip.jsonable import jsonable

COUNT_PERIOD_S = 1.0  # [s] between counts, where each would be a line

Report = Callable[[str], None]


def table(*header: str, wraps: str = "") -> Table:
    """Return an empty table; only the column ``wraps`` breaks its lines."""
    return Table(*(Column(name, no_wrap=name != wraps) for name in header), box=None, pad_edge=False)


def printer(*, stderr: bool = False) -> Console:
    """Return where sentences go: broken between words in a terminal, unbroken in a file."""
    console = Literal(stderr=stderr)
    return console if console.is_terminal else Literal(soft_wrap=True, width=WIDE_COLUMNS, stderr=stderr)


def show(content: Table) -> None:
    console = Literal()
    (console if console.is_terminal else Literal(width=WIDE_COLUMNS)).print(content)


def print_next(*words: object) -> None:
    printer().print(f"next: {shlex.join(map(str, words))}", soft_wrap=True)


def complain(sentence: str) -> None:
    Literal(stderr=True).print(f"vegrip: {sentence}", style="red", soft_wrap=True)


def print_sentences(sentences: Iterable[str]) -> None:
    for sentence in sentences:
        printer().print(f"- {sentence}")


def announce_page(what: str) -> Callable[[str], None]:
    return lambda address: print(f"{what}: {address}  (Ctrl-C ends)", flush=True)  # noqa: T201


def answer(result: Any, show: Callable[[], object], *, as_json: bool) -> None:
    """Print ``result`` as one JSON object, or have it shown to a person."""
    if as_json:
        print_json(result)
    else:
        show()


def print_json(result: Any) -> None:
    typer.echo(json_text(result))


def json_text(result: Any) -> str:
    return json.dumps(jsonable(result), allow_nan=False)


@contextmanager
def progress(what: str) -> Iterator[Report]:
    """Show what is being done and for how long: a line that changes in a terminal, lines elsewhere."""
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = printer(stderr=True)
    if not console.is_terminal:
        with _compiling(lambda text: print(f"{what}: {text}", file=sys.stderr)):  # noqa: T201
            yield lambda text: print(f"{what}: {text}", file=sys.stderr)  # noqa: T201
        return
    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(what, total=None)

        def report(text: str) -> None:
            bar.update(task, description=f"{what}: {text}")

        with _compiling(report):
            yield report


def counted(report: Report, things: str = "rows") -> Callable[[int], None]:
    """Return a function that reports a number of ``things``, at most once a second."""
    due = time.monotonic() + COUNT_PERIOD_S

    def report_count(count: int) -> None:
        nonlocal due
        if time.monotonic() >= due:
            due = time.monotonic() + COUNT_PERIOD_S
            report(f"{count:,} {things}".replace(",", " "))

    return report_count


@contextmanager
def _compiling(report: Report) -> Iterator[None]:
    """Let the compiler say when it compiles; it costs nothing where it is not imported yet."""
    from vegrip.compiling import compile_listener

    with compile_listener(report):
        yield
