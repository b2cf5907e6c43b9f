"""``vegrip record``: write what is on a bus to a folder."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._outputs import FORCE, claim_recording

OUT = Annotated[
    Path | None, typer.Option("-o", "--output", help="Folder to make; default recordings/<UTC time>.")
]
CONFIG = Annotated[Path | None, typer.Option(help="Launch file with a node `record`, to take its bus from.")]
SET = Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE, e.g. transport.channel=can0.")]
RADIUS = Annotated[str, typer.Option(help="Radius of the fingertips, e.g. '8 mm', written to the recording.")]


def record(
    output: OUT = None, force: FORCE = False, config: CONFIG = None, values: SET = None, radius: RADIUS = ""
) -> None:
    """Record a bus until interrupted: one recording per finger, and what the nodes say.

    Example, beside vegrip launch demo: vegrip record -o grasp --set name=recorder
    --set transport.channel=demo --set transport.interface=vegrip
    """
    import dataclasses
    from datetime import UTC, datetime

    from vegrip.cli.node import configured
    from vegrip.identification.recording.traces import replaced
    from vegrip.identification.recording.units import parse_length
    from vegrip.runtime.process import run_node

    node = configured("record", config, None, None, values or [])
    folder = output or Path(node.parameters.get("folder") or f"recordings/{datetime.now(UTC):%Y%m%d-%H%M%S}")
    written = {"folder": str(folder)} | ({"radius": parse_length(radius, "--radius")} if radius else {})
    claim_recording(folder, force=force)
    typer.echo(f"recording to {folder}; end it with Ctrl-C")
    with replaced(folder):
        run_node(dataclasses.replace(node, parameters={**node.parameters, **written}))
