"""``vegrip changed``: what changed between two recordings."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli import _terminal
from vegrip.cli._options import JSON, START_MODEL, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.errors import UsageError

FIRST = Annotated[Path, typer.Argument(help="Folder of the recording before, of a finger or a hand.")]
SECOND = Annotated[Path, typer.Argument(help="Folder of the recording after, of the same.")]
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
    Of recordings of a hand each finger has a verdict.

    Example: vegrip sample press && vegrip sample press-later
    && vegrip changed press press-later -o changed.png
    """
    from vegrip.identification.changed.changes import changed_fingers
    from vegrip.identification.changed.plot import changed_figure
    from vegrip.identification.recording.session import read_fingers
    from vegrip.model import read_model
    from vegrip.plotting import save_figure

    with Outputs(force=force) as outputs:
        outputs.picture(output)
        with _terminal.progress("read") as report:
            count = _terminal.counted(report)
            before, after = (read_fingers(folder, progress=count) for folder in (first, second))
        if len(before) == len(after) == 1:
            after = dict(zip(before, after.values(), strict=True))  # one finger, however it is called
        elif output is not None:
            raise UsageError(f"-o draws one finger: give its folder, such as {first / next(iter(before))}")
        start = read_model(model) if model is not None else None
        with _terminal.progress("changed") as report:
            found, left_out = changed_fingers(before, after, start, tolerance=tolerance, report=report)
        one = next(iter(found.values()))
        outputs.write(output, lambda path: save_figure(changed_figure(one), path))
        if as_json and len(before) == len(after) == 1:
            _terminal.print_json(one.as_dict())
        elif as_json:
            fingers = {finger: each.as_dict() for finger, each in found.items()}
            _terminal.print_json({"fingers": fingers, "not_compared": left_out})
        else:
            for each in found.values():
                _terminal.printer().print(f"{each.verdict} - {each.sentence}", style="bold")
                _terminal.print_sentences(each.remarks)
            reasons = left_out.items()
            _terminal.print_sentences(f"{finger} was not compared: {why}" for finger, why in reasons)
