"""``vegrip check``: a model against a recording, on a page."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import EACH, OPENS, PORT, TOLERANCE
from vegrip.cli._terminal import announce_page
from vegrip.cli.fit import error_options
from vegrip.errors import UsageError

RECORDING = Annotated[
    Path | None, typer.Argument(help="Folder of a recording; with --node it is made, LIVE by default.")
]
NODE = Annotated[str, typer.Option("--node", help="Record this running node first, and check its model.")]
FINGER = Annotated[str, typer.Option(help="Of the node; else the one that is pressed most.")]
SECONDS = Annotated[float, typer.Option(min=1.0, help="With --node: how long to record [s].")]
MODEL = Annotated[
    Path | None, typer.Option("--model", help="Model file to begin with; else the paper's model.")
]
OUT = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="DIR", help="Keeps models and state; RECORDING-check by default."),
]


def check(
    recording: RECORDING = None,
    model: MODEL = None,
    output: OUT = None,
    port: PORT = 8521,
    opens: OPENS = False,
    zeros_each_episode: EACH = False,
    tolerance: TOLERANCE = 0.0,
    node: NODE = "",
    finger: FINGER = "",
    seconds: SECONDS = 20.0,
) -> None:
    """See in the browser where a model fails, what it lacks, and how the error falls when it is added.

    The page, on loopback, runs the commands fit, compare, diagnose and add and shows each; its address,
    with a key, is printed. Started again it goes on where it was. With --node it records what a running
    node receives, checks the node's own model against it, and can write the better one back.

    Example: vegrip sample press && vegrip check press
    """
    from vegrip.web import require_web

    require_web()
    from vegrip.identification.recording import read_recording
    from vegrip.web.check.controller import run

    if node:
        recording, model = _recorded(node, recording or Path("live"), finger, seconds, model)
    if recording is None:
        raise UsageError("give the folder of a recording, or --node NAME of a running node")
    read_recording(recording)  # what cannot be read is refused before a page opens
    options = tuple(error_options(zeros_each_episode, tolerance))
    folder = output or Path(f"{recording.name}-check") if not node else recording.parent / "check"
    announce = announce_page("check page")
    run(recording, model, folder, options, port, announce, opens=opens, node=node or "grasp_force")


def _recorded(
    node: str, folder: Path, finger: str, seconds: float, model: Path | None
) -> tuple[Path, Path | None]:
    import numpy as np

    from vegrip.cli.record import record_from_node
    from vegrip.identification.recording.session import read_fingers

    own = record_from_node(node, folder, seconds)
    fingers = read_fingers(folder, announce=False)
    if finger and finger not in fingers:
        raise UsageError(f"{node} has no finger {finger!r}; it has {', '.join(fingers)}")
    pressed = {n: float(np.nanmax(r.columns["normal_force"])) for n, r in fingers.items() if len(r)}
    chosen = finger or max(pressed, key=lambda name: pressed[name])
    return folder / chosen, model or (Path(own) if own else None)
