"""Values that change, as a table that stays in its place."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from vegrip.transport.mapped.traffic import Now

PERIOD_S = 0.1  # [s] between two pictures


@contextmanager
def showing(now: "Now | None") -> Iterator[Callable[[], None]]:
    """Show ``now`` as long as the block lasts; what is given draws it again when it is time."""
    if now is None:
        yield lambda: None
        return
    from rich.live import Live

    from vegrip.cli._tables import printer

    drawn = 0.0
    with Live(_drawn(now), console=printer(), auto_refresh=False, transient=True) as live:

        def show() -> None:
            nonlocal drawn
            if time.monotonic() - drawn >= PERIOD_S:
                drawn = time.monotonic()
                live.update(_drawn(now), refresh=True)

        yield show


def _drawn(now: "Now") -> "Table":
    from vegrip.cli._tables import table

    content = table("from", "what", "now", "unit")
    for source, name, value, unit in now.rows():
        content.add_row(source, name, "-" if math.isnan(value) else f"{value:.4g}", unit)
    return content
