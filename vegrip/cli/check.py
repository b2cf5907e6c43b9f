"""``vegrip check``: a model against a recording, on a page."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._fits import EACH, TOLERANCE

RECORDING = Annotated[Path, typer.Argument(help="Folder of a recording.")]
MODEL = Annotated[
    Path | None, typer.Option("--model", help="Model file to begin with; else the paper's model.")
]
OUT = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="DIR", help="Keeps models and state; RECORDING-check by default."),
]
PORT = Annotated[int, typer.Option(min=0, max=65535, help="of the page; 0 = any free one")]
OPENS = Annotated[bool, typer.Option("--open", help="open the page in the browser")]


def check(
    recording: RECORDING,
    model: MODEL = None,
    output: OUT = None,
    port: PORT = 8521,
    opens: OPENS = False,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
) -> None:
    """See in the browser where a model fails, what it lacks, and how the error falls when it is added.

    The page, on loopback, runs the commands fit, compare, diagnose and add and shows each; its address,
    with a key, is printed. Started again it goes on where it was.

    Example: vegrip sample press && vegrip check press
    """
    from vegrip.web.need import require_web

    require_web()
    from vegrip.identification.recording import read_recording
    from vegrip.web.check.run import run

    read_recording(recording)  # what cannot be read is refused before a page opens
    options: tuple[str, ...] = ("--zeros-each-episode",) if zeros_each_episode else ()
    if tolerance > 0.0:
        options += ("--tolerance", f"{tolerance:g}")

    def announce(address: str) -> None:
        print(f"check page: {address}  (Ctrl-C ends)", flush=True)  # noqa: T201

    folder = output or Path(f"{recording.name}-check")
    run(recording, model, folder, options, port, announce, opens=opens)
