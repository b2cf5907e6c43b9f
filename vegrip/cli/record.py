"""``vegrip record``: write what is on a bus to a folder."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import SET
from vegrip.cli._outputs import FORCE, claim_recording
from vegrip.cli._terminal import counted, progress
from vegrip.errors import DeviceError, UsageError

OUT = Annotated[
    Path | None, typer.Option("-o", "--output", help="Folder to make; default recordings/<UTC time>.")
]
CONFIG = Annotated[Path | None, typer.Option(help="Launch file with a node `record`, to take its bus from.")]
RADIUS = Annotated[str, typer.Option(help="Radius of the fingertips, e.g. '8 mm', written to the recording.")]
NODE = Annotated[
    str, typer.Option("--node", help="Record what this running node receives and says, without its bus.")
]
SECONDS = Annotated[float, typer.Option(min=0.0, help="With --node: how long [s]; 0 = until Ctrl-C.")]


def record(
    output: OUT = None,
    force: FORCE = False,
    config: CONFIG = None,
    values: SET = None,
    radius: RADIUS = "",
    node_name: NODE = "",
    seconds: SECONDS = 0.0,
) -> None:
    """Record a bus until interrupted: one recording per finger, and what the nodes say.

    With --node it is what a running node receives and says, from its telemetry; radius and model are asked
    from the node.

    Example, beside vegrip launch demo: vegrip record -o grasp --set name=recorder
    --set transport.channel=demo --set transport.interface=vegrip
    """
    import dataclasses
    from datetime import UTC, datetime

    from vegrip.cli.node import configured
    from vegrip.identification.recording.session import replaced
    from vegrip.identification.recording.units import parse_length
    from vegrip.runtime.process import run_node

    if node_name:
        if config is not None or values:
            raise UsageError("--node records a node that runs; leave --config and --set out")
        record_from_node(
            node_name, output or Path(f"recordings/{node_name.strip('/')}"), seconds, force=force
        )
        return
    if seconds:
        raise UsageError("--seconds belongs to --node NAME; a bus is recorded until Ctrl-C")
    node = configured("record", config, None, None, values or [])
    folder = output or Path(node.parameters.get("folder") or f"recordings/{datetime.now(UTC):%Y%m%d-%H%M%S}")
    written = {"folder": str(folder)} | ({"radius": parse_length(radius, "--radius")} if radius else {})
    claim_recording(folder, force=force)
    typer.echo(f"recording to {folder}; end it with Ctrl-C")
    with replaced(folder):
        run_node(dataclasses.replace(node, parameters={**node.parameters, **written}))
        fingers = sorted(path.parent.name for path in folder.glob("*/recording.csv"))
        if not fingers:
            raise DeviceError(
                f"{folder} holds no hand: no state of a finger came; is it on, and is this its bus?"
            )
        typer.echo(f"{folder}: {', '.join(fingers)}", err=True)


def record_from_node(name: str, folder: Path, seconds: float, *, force: bool = False) -> str:
    """Record a running node into ``folder``; return the model file of its fingertips, empty where none."""
    from vegrip.identification.recording.session import replaced
    from vegrip.identification.recording.writer import RecordingWriter
    from vegrip.runtime.registry import find_node
    from vegrip.runtime.replay.listen import record_node, tip_of

    entry = find_node(name)
    model, radius = tip_of(entry)
    claim_recording(folder, force=force)
    with replaced(folder), RecordingWriter(folder, radius=radius) as writer, progress("record") as report:
        try:
            states = record_node(entry, writer, seconds, counted(report, "states"))
        except KeyboardInterrupt:
            states = sum(writer.rows.values())
    typer.echo(f"{folder}: {states} states of {name}", err=True)
    return model
