"""``vegrip doctor``: what stands in the way on this machine."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import JSON
from vegrip.cli._terminal import print_json, print_sentences, printer, show, table
from vegrip.errors import UsageError, suggestion


def doctor(
    file: Annotated[
        str,
        typer.Argument(
            help="Launch file or map, or one of vegrip's own: what bounds its grip, and which part answers."
        ),
    ] = "",
    recordings: Annotated[Path, typer.Option(help="Folder that recordings go to.")] = Path(),
    sensors: Annotated[
        bool, typer.Option("--sensors", help="Say instead what which sensors of a fingertip give you.")
    ] = False,
    channels: Annotated[
        str, typer.Option("--channels", help="Yours, by commas, or a recording; with --sensors.")
    ] = "",
    as_json: JSON = False,
) -> None:
    """Check kernel, clock, scheduler, rights, CAN interfaces, compiler cache and disk of this machine.

    Each line is ok, warn or fail, with the remedy. The exit code is 0, or 4 if anything fails.

    Example: vegrip doctor demo

    Of a hand in parts (sensors, drive) each is opened alone, and what answers is said; a gripper may move.

    What a hand without tangential forces gets: vegrip doctor --sensors --channels normal_force,displacement
    """
    from vegrip.runtime.doctor import Grade, examine, largest_forces, worst
    from vegrip.runtime.launch_file import find_launch_file

    if sensors or channels:
        _show_sensors(channels, as_json=as_json)
        return
    if not recordings.is_dir():
        recordings = next(parent for parent in recordings.resolve().parents if parent.is_dir())
    findings = examine(recordings=recordings)
    if file:
        from vegrip.connect.parts import try_parts

        path = find_launch_file(file)
        findings += [*largest_forces(path), *try_parts(path)]
    if as_json:
        result = [
            {"check": f.check, "grade": f.grade.name.lower(), "text": f.text, "remedy": f.remedy}
            for f in findings
        ]
        print_json({"grade": worst(findings).name.lower(), "findings": result})
    else:
        from rich.text import Text

        colours = {Grade.OK: "green", Grade.WARN: "yellow", Grade.FAIL: "red"}
        for f in findings:
            mark = Text(f"{f.grade.name.lower():5}", style=colours[f.grade])
            printer().print(mark + Text(f" {f.check:15} {f.text}", style="default"), soft_wrap=True)
            if f.remedy and f.grade is not Grade.OK:
                printer().print(f"{'':21} {f.remedy}", soft_wrap=True)
    if worst(findings) is Grade.FAIL:
        raise typer.Exit(4)


def _show_sensors(given: str, *, as_json: bool) -> None:
    from vegrip.identification.sensors import LOAD_REMEDY, OUTPUT_NEEDS, USUAL_SENSORS, answers, lacking

    sets = {given: _channels(given)} if given else USUAL_SENSORS
    if as_json:
        result = {
            name: {"outputs": answers(one), "lacking": lacking(one, LOAD_REMEDY)}
            for name, one in sets.items()
        }
        print_json(result)
        return
    content = table("measured", *(output.short for output in OUTPUT_NEEDS))
    for name, one in sets.items():
        content.add_row(name, *("yes" if output.given(one) else "-" for output in OUTPUT_NEEDS))
    show(content)
    console = printer()
    for output in OUTPUT_NEEDS:
        console.print(f"{output.short}: {output.name}; needs {output.needs}; without: {output.otherwise}")
    print_sentences(lacking(sets[given], LOAD_REMEDY) if given else ())


def _channels(given: str) -> tuple[str, ...]:
    from vegrip.identification.recording import read_recording
    from vegrip.identification.recording.channels import CHANNELS

    if Path(given).is_dir():
        return tuple(read_recording(given).columns)
    names = tuple(name.strip() for name in given.split(",") if name.strip())
    for name in names:
        if name not in CHANNELS:
            raise UsageError(f"there is no channel {name!r}; {suggestion(name, CHANNELS)}")
    return names
