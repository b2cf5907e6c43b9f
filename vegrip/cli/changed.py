"""``vegrip changed``: what changed between two recordings."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vegrip.cli import _terminal
from vegrip.cli._options import JSON, START_MODEL, TOLERANCE
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.errors import UsageError

if TYPE_CHECKING:
    from vegrip.identification.recording import Recording

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
    from vegrip.identification.changed.hand import changed_fingers
    from vegrip.identification.changed.plot import draw_changed
    from vegrip.model import read_model

    with Outputs(force=force) as outputs:
        outputs.picture(output)
        before, after = _fingers(first), _fingers(second)
        if len(before) == len(after) == 1:
            after = dict(zip(before, after.values(), strict=True))  # one finger, however it is called
        elif output is not None:
            raise UsageError(f"-o draws one finger: give its folder, such as {first / next(iter(before))}")
        start = read_model(model) if model is not None else None
        with _terminal.progress("changed") as report:
            found = changed_fingers(before, after, start, tolerance=tolerance, report=report)
        one = next(iter(found.fingers.values()))
        is_hand = len(before) > 1 or len(after) > 1
        outputs.write(output, partial(draw_changed, one))
        if as_json:
            _terminal.print_json(found.as_dict() if is_hand else one.as_dict())
            return
        for each in found.fingers.values():
            _terminal.printer().print(f"{each.verdict} - {each.sentence}", style="bold")
            _terminal.print_sentences(each.remarks)
        left_out = found.not_compared.items()
        _terminal.print_sentences(f"{finger} was not compared: {why}" for finger, why in left_out)


def _fingers(folder: Path) -> "dict[str, Recording]":
    from vegrip.identification.recording import read_recording
    from vegrip.identification.recording.session import finger_folders

    with _terminal.progress("read") as report:
        places = finger_folders(folder)
        found = [read_recording(place, progress=_terminal.counted(report)) for place in places]
    return {one.fingertip.name: one for one in found}
