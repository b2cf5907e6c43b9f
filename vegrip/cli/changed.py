"""``vegrip changed``: what changed between two recordings."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli import _terminal
from vegrip.cli._options import JSON, START_MODEL, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs

FIRST = Annotated[Path, typer.Argument(help="Folder of the recording before.")]
SECOND = Annotated[Path, typer.Argument(help="Folder of the recording after, of the same finger.")]
PLOT = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="PNG", help="Draw both and their difference.")
]


def changed(
    first: FIRST,
    second: SECOND,
    model: START_MODEL = None,
    output: PLOT = None,
    force: FORCE = False,
    tolerance: TOLERANCE = 0.0,
    as_json: JSON = False,
) -> None:
    """Say what changed of a fingertip between two recordings: pad, sensor or friction, and by how much.

    The verdict is one of four: nothing; named (these values, with intervals of 95 %); ambiguous (one of
    several, and what would separate them); new_effect (the second shows an effect that the first does not).

    Example: vegrip sample press && vegrip sample press-later
    && vegrip changed press press-later -o changed.png
    """
    from vegrip.cli.fit import opened
    from vegrip.identification.changed import changed as find_changes
    from vegrip.identification.changed.plot import draw_changed

    with Outputs(force=force) as outputs:
        outputs.picture(output)
        before, start = opened(first, model)
        after, _ = opened(second, None)
        with _terminal.progress("changed") as report:
            found = find_changes(before, after, start, tolerance=tolerance, report=report)
        outputs.write(output, partial(draw_changed, found))
        if as_json:
            _terminal.print_json(found.as_dict())
            return
        _terminal.printer().print(f"{found.verdict} - {found.sentence}", style="bold")
        _terminal.print_sentences(found.remarks)
