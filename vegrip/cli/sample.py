"""``vegrip sample``: something to try the commands on."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, claim_file, claim_recording
from vegrip.cli._terminal import answer, printer, show, table
from vegrip.errors import UsageError, suggestion
from vegrip.identification.samples import SAMPLES

NAME = Annotated[str, typer.Argument(help=f"One of {', '.join(SAMPLES)}; without a name all are listed.")]
OUT = Annotated[
    Path | None, typer.Option("-o", "--output", help="Where to write it; by default here, under its name.")
]


def sample(name: NAME = "", output: OUT = None, force: FORCE = False, as_json: JSON = False) -> None:
    """Write a sample recording, table, CAN log or model here; the examples of all commands use them.

    Example: vegrip sample press
    """
    if not name:
        answer({name: one.about for name, one in SAMPLES.items()}, _list, as_json=as_json)
        return
    if name not in SAMPLES:
        raise UsageError(f"there is no sample {name!r}; {suggestion(name, SAMPLES)}")
    path = output or Path(name)
    if force or not SAMPLES[name].is_at(path):  # a second time is no mistake
        (claim_file if "." in name else claim_recording)(path, force=force)
        SAMPLES[name].write(path)
    said = f"{path}: {SAMPLES[name].about}"
    answer({"sample": name, "path": str(path)}, lambda: printer().print(said), as_json=as_json)


def _list() -> None:
    content = table("sample", "what it is", wraps="what it is")
    for name, one in SAMPLES.items():
        content.add_row(name, one.about)
    show(content)
