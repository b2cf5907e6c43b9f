"""Long work shows itself on standard error: what is being done, and since when."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from vegrip.cli._tables import printer

Report = Callable[[str], None]
EVERY = 1.0  # [s] between counts, where each would be a line


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


def counted(report: Report) -> Callable[[int], None]:
    """Return what tells a number of rows, at most once a second."""
    due = time.monotonic() + EVERY

    def tell(rows: int) -> None:
        nonlocal due
        if time.monotonic() >= due:
            due = time.monotonic() + EVERY
            report(f"{rows:,} rows".replace(",", " "))

    return tell


@contextmanager
def _compiling(report: Report) -> Iterator[None]:
    """Let the compiler say when it compiles; it costs nothing where it is not imported yet."""
    from vegrip.compiling import compile_listener

    with compile_listener(report):
        yield
