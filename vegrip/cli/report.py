"""``vegrip report``: one file of HTML to read, to send on and to print."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, Outputs, claim_file
from vegrip.cli._terminal import answer, printer, progress
from vegrip.whole_file import write_whole

WHAT = Annotated[
    Path,
    typer.Argument(help="Folder of a recording, of a recorded run, of `vegrip check` or `refine --report`."),
]
MODEL = Annotated[
    Path | None, typer.Option("--model", help="Of a recording: model file to begin with; else the paper's.")
]
OUT = Annotated[
    Path | None, typer.Option("-o", "--output", help="File to write; NAME-report.html by default.")
]


def report(
    what: WHAT, model: MODEL = None, output: OUT = None, force: FORCE = False, as_json: JSON = False
) -> None:
    """Write a report that needs nothing but a browser: all in one file, printable.

    Of a recording: what was measured, where the model failed, what was added, the ladder of errors,
    parameters with errors, what remains unknown, and the commands that make it again. Of a recorded run of
    the node: margins, slips, commands, faults and latencies.

    Example: vegrip sample press && vegrip report press -o press-report.html
    """
    from vegrip.model import read_model
    from vegrip.web.report.make import make_report

    target = output or Path(f"{what.resolve().name}-report.html")
    claim_file(target, force=force)  # the page is the whole answer
    start = read_model(model) if model is not None else None
    with progress("report") as say:
        text = make_report(what, start, model, say)
    with Outputs(force=force) as outputs:
        if outputs.write(target, lambda path: write_whole(path, text)):
            said = f"{target}: open it in a browser, print it to PDF there"
            result = {"report": str(target), "bytes": len(text.encode())}
            answer(result, lambda: printer().print(said), as_json=as_json)
