"""``vegrip fleet``: many recordings, one table."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON, START_MODEL
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import answer, printer, show, table
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from vegrip.identification.fleet import Finding, Found, Row

FOLDER = Annotated[Path, typer.Argument(help="Folder with recordings in it, at any depth.")]
OUT = Annotated[Path | None, typer.Option("-o", "--output", metavar="CSV", help="Write the table.")]
LEDGER = Annotated[
    Path | None,
    typer.Option("--ledger", help="File of results; else .vegrip-fleet.jsonl in the folder."),
]
PROCESSES = Annotated[int, typer.Option("-j", "--processes", min=0, help="On this machine; 0: all cores.")]
SCHEDULER = Annotated[
    str, typer.Option("--scheduler", metavar="ADDRESS", help="Of a Dask cluster, tcp://host:8786.")
]


def fleet(
    folder: FOLDER,
    model: START_MODEL = None,
    output: OUT = None,
    force: FORCE = False,
    ledger: LEDGER = None,
    processes: PROCESSES = 0,
    scheduler: SCHEDULER = "",
    as_json: JSON = False,
) -> None:
    """Diagnose every recording below a folder: which hand, which pad, which effect, since when.

    Hand, pad and date come from the source table of recording.toml (hand, pad, date), else from folder,
    finger and file. A recording that cannot be used is a row that says why. A run that was stopped goes on
    where it was, and recordings that have not changed are not examined again.

    Example: vegrip sample press -o recordings/press && vegrip fleet recordings -o fleet.csv
    """
    from vegrip.identification.fleet import find_recordings, run, summarize_rows
    from vegrip.identification.fleet.row import Ledger, csv_text
    from vegrip.model import read_model

    with Outputs(force=force) as outputs:
        outputs.file(output)
        if model is not None:
            read_model(model)  # a wrong one is reported here, once
            model = model.resolve()
        known = Ledger(
            ledger if ledger is not None else folder / ".vegrip-fleet.jsonl",
            model.read_text(encoding="utf-8") if model is not None else "",
        )
        found = find_recordings(folder)
        done = [(one, row) for one in found if (row := known.row(one)) is not None]
        left = [one for one in found if known.row(one) is None]
        with _counted(len(found), len(done)) as count:
            for one, row in run(left, str(model or ""), processes=processes, scheduler=scheduler):
                known.add(one, row)
                done.append((one, row))
                count(one, row)
        table = summarize_rows(done)
        written = outputs.write(output, lambda path: write_whole(path, csv_text(table)))
        in_order = sorted(done, key=lambda pair: (pair[0].date, pair[0].path))
        recordings = [{**asdict(found), **asdict(row)} for found, row in in_order]
        answer(
            {"findings": [asdict(one) for one in table], "recordings": recordings},
            lambda: _print(table, done, output if written else None),
            as_json=as_json,
        )


@contextmanager
def _counted(total: int, done: int) -> Iterator[Any]:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = printer(stderr=True)
    if not console.is_terminal:
        number = done
        print(f"{total} recordings, {done} of them known", file=sys.stderr)  # noqa: T201

        def line(found: "Found", row: "Row") -> None:
            nonlocal number
            number += 1
            print(f"{number} of {total}: {found.path}: {row.verdict}", file=sys.stderr)  # noqa: T201

        yield line
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("recordings", total=total, completed=done)
        yield lambda found, row: bar.update(
            task, advance=1, description=f"{found.hand} {found.pad}: {row.verdict}"
        )


def _print(findings: "list[Finding]", done: "list[tuple[Found, Row]]", output: Path | None) -> None:
    from vegrip.identification.fleet.row import FAILED, NONE

    shown = table("hand", "pad", "effect", "since", "seen in", "now", "size", wraps="size")
    for one in findings:
        if one.effect in (FAILED, NONE):
            continue
        since = one.since[:10] + ("" if one.dated_by == "recording" else " (of the file)")
        now = "yes" if one.present else f"not after {one.until[:10]}"
        shown.add_row(one.hand, one.pad, one.effect, since, f"{one.shown} of {one.judged}", now, one.size)
    for one in findings:
        if one.effect == NONE:
            shown.add_row(one.hand, one.pad, "nothing missing", "", f"{one.shown} of {one.judged}", "", "")
    show(shown)
    console = printer()
    failed = [one for one in findings if one.effect == FAILED]
    sentences = [
        f"{one.hand} {one.pad}, {one.effect}: {one.note}"
        for one in findings
        if one.note and one.effect != FAILED
    ]
    sentences += [f"not judged: {one.note}" for one in failed]
    sentences += [f"{found.path}: {row.lost}" for found, row in done if row.lost]
    if (alone := sum(found.is_alone for found, _ in done)) > 1:
        sentences.append(
            f"{alone} recordings do not say of which hand and pad they are, and each counts as a pad of its "
            "own; state hand and pad in [source] of recording.toml, or make a folder for each hand"
        )
    for text in sentences:
        console.print(f"- {text}")
    pads = {(one.hand, one.pad) for one in findings if one.effect != FAILED}
    console.print(
        f"{len(done)} recordings, {len(failed)} of them not judged; "
        f"the others are of {len(pads)} pads of {len({hand for hand, _ in pads})} hands"
    )
    if output is not None:
        console.print(f"table in {output}")
