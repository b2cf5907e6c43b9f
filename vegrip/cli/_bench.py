"""``vegrip connect --sensor --drive``: the questions of a bench, and its files."""

import sys
from collections.abc import Sequence
from pathlib import Path

import typer

from vegrip.cli._outputs import claim_file
from vegrip.cli._terminal import complain
from vegrip.connect.bench_file import (
    AXES,
    Answers,
    launch_text,
    listen_to_all,
    map_of_pad,
    sources_of,
    which_is_pressed,
)
from vegrip.errors import InputError, UsageError
from vegrip.runtime.launch_file import read_launch_file
from vegrip.transport.hands.bench import JAWS, Source
from vegrip.transport.maps.map_text import Setting
from vegrip.whole_file import write_whole

LISTEN_S = 3.0  # [s] at rest, and while a pad is pressed


def connect_bench(
    sensors: Sequence[str],
    drive: str,
    output: Path | None,
    fingers: str,
    heaviest: float,
    said: Sequence[Setting],
    *,
    ask: bool,
    force: bool,
) -> None:
    """Write the launch file of a bench, and beside it the map of each pad."""
    if not sensors or not drive or output is None:
        raise UsageError("a bench needs a --sensor PRODUCT@PORT for each pad, a --drive, and -o FILE")
    sides = [name.strip() for name in fingers.split(",") if name.strip()] or list(JAWS[: len(sensors)])
    if len(sides) != len(sensors):
        raise UsageError(f"{len(sensors)} sensors and {len(sides)} --fingers; name one for each sensor")
    sources, presses = sources_of(sensors), sources_of([drive])[0]
    answers = Answers(sides, {}, {}, heaviest)
    if ask and sys.stdin.isatty():
        answers = _asked(sources, sides, heaviest)
    files = [output.parent / f"{side}.toml" for side in answers.sides]
    for path in (output, *files):
        claim_file(path, force=force)
    output.parent.mkdir(parents=True, exist_ok=True)
    launch = launch_text(sides, presses, answers.heaviest)
    for path, source, side in zip(files, sources, answers.sides, strict=True):
        write_whole(path, map_of_pad(source, side, answers, said))
    write_whole(output, launch)
    read_launch_file(output)  # says what does not fit together
    written = ", ".join(str(path) for path in (output, *files))
    typer.echo(f"written: {written}; next: vegrip doctor {output}, then vegrip launch {output}")


def _asked(sources: Sequence[Source], sides: Sequence[str], heaviest: float) -> Answers:
    """Ask which pad is where, which axis points up, and how heavy objects are."""
    named = {source.text: source for source in sources}
    signs: dict[str, int] = {}
    order = dict(zip(named, sides, strict=True))
    typer.prompt("touch nothing, and press Enter", default="", show_default=False)
    rest = listen_to_all(named, LISTEN_S)
    for side in sides[: len(sides) - 1 or 1]:
        typer.prompt(
            f"press the pad of the {side} jaw, keep it pressed, Enter", default="", show_default=False
        )
        pressed, sign = which_is_pressed(rest, listen_to_all(named, LISTEN_S))
        signs[side] = sign
        if order[pressed] != side:
            complain(f"{side} and {order[pressed]} are swapped: {pressed} is {side}, and is written so")
            other = next(text for text, each in order.items() if each == side)
            order[other], order[pressed] = order[pressed], side
    up = {}
    for side in sides:
        axis = typer.prompt(f"which axis of the {side} sensor points up, {', '.join(AXES)}", default="x")
        if axis not in AXES:
            raise InputError(f"{axis!r} is no axis; there are {', '.join(AXES)}")
        up[side] = axis
    mass = heaviest or typer.prompt("mass of the heaviest object [kg]", default=0.5, type=float)
    return Answers([order[source.text] for source in sources], up, signs, mass)
