"""``vegrip connect --sensor --drive``: the questions of a bench, and its files."""

import json
import math
import re
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import typer

from vegrip.cli._outputs import claim_file
from vegrip.cli._terminal import complain
from vegrip.connect.bench_file import (
    AXES,
    Answers,
    Named,
    largest_for,
    launch_text,
    listen_to_all,
    map_of_drive,
    map_of_pads,
    named,
    said_of_parts,
    source_of,
    which_is_pressed,
)
from vegrip.connect.parts import benches
from vegrip.errors import InputError, UsageError
from vegrip.identification.recording.report import account
from vegrip.transport.hands.bench import JAWS, OTHER_PARTS, Bench, Source
from vegrip.transport.maps.map_text import Setting
from vegrip.transport.open import map_and_port
from vegrip.whole_file import or_as_before, write_whole

LISTEN_S: Final = 3.0  # [s] at rest, and while a pad is pressed
HUB: Final = "pads"  # the map of both at one port
NAME: Final = re.compile(r"[\w-]+")
MOST_KG: Final = 1000.0  # that is asked for; more is a slip of the hand


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
    as_json: bool,
) -> None:
    """Write the launch file of a bench, and beside it the map of each pad."""
    if not sensors or not drive or output is None:
        raise UsageError("a bench needs a --sensor PRODUCT@PORT for each pad, a --drive, and -o FILE")
    pads, presses = [named(text) for text in sensors], named(drive)
    sides = [name.strip() for name in fingers.split(",") if name.strip()]
    of_hub = pads[0].fingers if len(pads) == 1 and not sides else []
    is_hub = len(of_hub) > 1  # both pads at one port, which tells them apart itself
    sides = sides or (of_hub if is_hub else list(JAWS[: len(sensors)]))
    if len(sides) != len(sensors) and not is_hub:
        raise UsageError(
            f"{len(sensors)} sensors and {len(sides)} --fingers; name one for each sensor, and none for a "
            "hub, whose pads keep their names"
        )
    _check(sensors, sides, [HUB] if is_hub else sides, output, heaviest)
    groups = {HUB: sides} if is_hub else {side: [side] for side in sides}
    of_pads, of_drive = said_of_parts(said, groups, presses.fingers)
    with tempfile.TemporaryDirectory(prefix="vegrip-connect-") as folder:
        scratch = [Path(folder) / f"{number}.toml" for number in range(len(pads) + 1)]
        sources = [
            source_of(pad, map_of_pads(pad, group, of_pads[name]), file)
            for pad, (name, group), file in zip(pads, groups.items(), scratch[1:], strict=True)
        ]
        press = source_of(presses, map_of_drive(presses, of_drive), scratch[0])
        answers = Answers(sides, {}, {}, heaviest)
        if ask and sys.stdin.isatty() and not as_json:
            answers = _asked(sources, sides, heaviest)
        largest = largest_for(answers.heaviest, press) if answers.heaviest else 0.0
    texts = {
        output.parent / f"{name}.toml": map_of_pads(pad, groups[name], of_pads[name], answers)
        for pad, name in zip(pads, groups if is_hub else answers.sides, strict=True)
    }
    reference = _reference(presses, output.parent)
    if of_drive:
        reference = "drive.toml"
        texts[output.parent / reference] = map_of_drive(presses, of_drive)
    texts = {output: launch_text(groups, sides, reference, largest), **texts}
    for path in texts:
        claim_file(path, force=force)
    output.parent.mkdir(parents=True, exist_ok=True)
    with or_as_before(*texts):
        for path, text in texts.items():
            write_whole(path, text)
        ((_, bench),) = benches(output)  # says what does not fit together
    if as_json:
        typer.echo(json.dumps(_as_dict(output, bench)))
        return
    written = ", ".join(map(str, texts))
    typer.echo(f"written: {written}; next: vegrip doctor {output}, then vegrip launch {output}")


def _reference(given: Named, folder: Path) -> str:
    """Return how the launch file in ``folder`` names a part whose map stays where it is."""
    if not given.text.startswith(str(given.path)):
        return given.text
    path = given.path.resolve()
    name = path.name if path.parent == folder.resolve() else str(path)
    return f"{name}@{given.port}" if given.port else name


def _as_dict(output: Path, bench: Bench) -> dict[str, Any]:
    """Return what `vegrip connect --json` says of any map."""
    felt = {source.names[one.name]: one.measured for source in bench.sensors for one in source.plan.fingers}
    return {
        "map": str(output),
        "ready": True,
        "fingers": {name: sorted(measured) for name, measured in felt.items()},
        "values": None,
        **{key: [] for key in ("learned", "open", "implausible", "lost")},
        "rows": account([]),
        "price": bench.sentences(),
    }


def _check(
    sensors: Sequence[str], sides: Sequence[str], files: Sequence[str], output: Path, heaviest: float
) -> None:
    """Refuse what would write two parts into one file, or into another folder."""
    if doubled := next((text for text in sensors if sensors.count(text) > 1), ""):
        raise UsageError(f"--sensor {doubled} is given twice; each has its own port, a hub is given once")
    if doubled := next((side for side in sides if sides.count(side) > 1), ""):
        raise UsageError(f"--fingers has {doubled!r} twice; each pad has its own name")
    if taken := next((side for side in sides if side in OTHER_PARTS), ""):
        raise UsageError(f"--fingers has {taken!r}, which is what another part of a bench is called")
    if wrong := next((side for side in sides if not NAME.fullmatch(side)), ""):
        raise UsageError(
            f"--fingers has {wrong!r}; a name has letters, digits, - and _, and is that of a file"
        )
    if output.name in (f"{file}.toml" for file in files):
        raise UsageError(f"{output} is also the map of that pad; give -o another name, as bench.toml")
    if not math.isfinite(heaviest):
        raise UsageError(f"--heaviest is {heaviest:g}; give a mass in kg")


def _asked(sources: Sequence[Source], sides: Sequence[str], heaviest: float) -> Answers:
    """Ask which pad is where, which axis points up, and how heavy objects are."""
    by_text = {source.text: source for source in sources}
    signs: dict[str, int] = {}
    sign_of: dict[str, int] = {}  # by product
    is_hub = len(by_text) < len(sides)
    order = dict(zip(sides if is_hub else by_text, sides, strict=True))
    typer.prompt("touch nothing, and press Enter", default="", show_default=False)
    rest = listen_to_all(by_text, LISTEN_S)
    if is_hub:
        signs = dict.fromkeys(sides, _pressed("press a pad, keep it pressed, Enter", by_text, rest)[1])
    for side in () if is_hub else sides[: len(sides) - 1 or 1]:
        pressed, sign = _pressed(f"press the pad of the {side} jaw, keep it pressed, Enter", by_text, rest)
        signs[side] = sign_of[map_and_port(pressed)[0]] = sign
        if order[pressed] != side:
            complain(f"{side} and {order[pressed]} are swapped: {pressed} is {side}, and is written so")
            other = next(text for text, each in order.items() if each == side)
            order[other], order[pressed] = order[pressed], side
    up = {}
    for side in sides:
        question = f"which axis of the {side} sensor points up, {', '.join(AXES)}"
        up[side] = typer.prompt(question, default="x", value_proc=_axis)
    mass = heaviest or typer.prompt("mass of the heaviest object [kg]", default="0.5", value_proc=_mass)
    for text, side in order.items():  # what one of a product does with its sign, the other does too
        signs.setdefault(side, sign_of.get(map_and_port(text)[0], 1))
    return Answers(list(order.values()), up, signs, mass)


def _pressed(question: str, by_text: Mapping[str, Source], rest: Mapping[str, float]) -> tuple[str, int]:
    """Ask until it is clear which pad is pressed."""
    while True:
        typer.prompt(question, default="", show_default=False)
        felt = listen_to_all(by_text, LISTEN_S)
        try:
            return which_is_pressed(rest, felt)
        except InputError as error:
            if any(math.isnan(force) for force in (*rest.values(), *felt.values())):
                raise  # another press helps no silent pad
            complain(str(error))


def _axis(text: str) -> str:
    if text.strip() not in AXES:
        raise typer.BadParameter(f"{text!r} is no axis; there are {', '.join(AXES)}")
    return text.strip()


def _mass(text: str) -> float:
    try:
        mass = float(text)
    except ValueError:
        mass = math.nan
    if not 0.0 < mass < MOST_KG:
        raise typer.BadParameter(f"{text!r} is no mass; give a number of kg, as 0.5")
    return mass
