"""``vegrip doctor``: what stands in the way on this machine."""

import json
from pathlib import Path
from typing import Annotated

import typer


def doctor(
    recordings: Annotated[Path, typer.Option(help="Folder that recordings go to.")] = Path(),
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check kernel, clock, scheduler, rights, CAN interfaces, compiler cache and disk of this machine.

    Each line is ok, warn or fail, with the remedy. The exit code is 0, or 4 if anything fails.

    Example: vegrip doctor
    """
    from vegrip.doctor import Grade, examine, worst

    if not recordings.is_dir():
        recordings = next(parent for parent in recordings.resolve().parents if parent.is_dir())
    findings = examine(recordings=recordings)
    if as_json:
        told = [
            {"check": f.check, "grade": f.grade.name.lower(), "text": f.text, "remedy": f.remedy}
            for f in findings
        ]
        typer.echo(json.dumps({"grade": worst(findings).name.lower(), "findings": told}))
    else:
        from rich.text import Text

        from vegrip.cli._tables import printer

        colours = {Grade.OK: "green", Grade.WARN: "yellow", Grade.FAIL: "red"}
        for f in findings:
            mark = Text(f"{f.grade.name.lower():5}", style=colours[f.grade])
            printer().print(mark + Text(f" {f.check:15} {f.text}", style="default"), soft_wrap=True)
            if f.remedy and f.grade is not Grade.OK:
                printer().print(f"{'':21} {f.remedy}", soft_wrap=True)
    if worst(findings) is Grade.FAIL:
        raise typer.Exit(4)
