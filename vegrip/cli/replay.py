"""``vegrip replay``: play a recording on a bus, or run the node over it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vegrip.cli._outputs import FORCE, Outputs, claim_recording

if TYPE_CHECKING:
    from vegrip.identification.recording import Recording

RECORDING = Annotated[Path, typer.Argument(help="Folder of a recording or of a session.")]
CONFIG = Annotated[Path | None, typer.Option(help="Launch file with a node `replay`, to take its bus from.")]
SET = Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE, e.g. transport.channel=can0.")]
FINGER = Annotated[str, typer.Option(help="Play a single recording as this finger.")]
SPEED = Annotated[float, typer.Option(min=0.01, max=100.0, help="Faster or slower than recorded.")]
THROUGH = Annotated[
    bool, typer.Option("--through", help="Run the grasp_force node over it, in simulated time.")
]
PARAMETERS = Annotated[Path | None, typer.Option(help="With --through: parameters of the node (TOML).")]
CLASSIC = Annotated[bool, typer.Option("--classic", help="With --through: classic CAN instead of CAN FD.")]
LOAD = Annotated[
    float | None,
    typer.Option(
        "--load", min=0.0, help="With --through: tangential load of each finger [N] where none is measured."
    ),
]
MASS = Annotated[
    float | None,
    typer.Option("--mass", min=0.0, help="With --through: mass that the fingers hold [kg], for --load."),
]
OUT = Annotated[Path | None, typer.Option("-o", "--output", help="With --through: session to write.")]
PLOT = Annotated[Path | None, typer.Option(help="With --through: picture to draw (needs matplotlib).")]
JSON = Annotated[bool, typer.Option("--json", help="With --through: print one JSON object.")]


def replay(
    recording: RECORDING,
    config: CONFIG = None,
    values: SET = None,
    finger: FINGER = "",
    speed: SPEED = 1.0,
    through: THROUGH = False,
    parameters: PARAMETERS = None,
    classic: CLASSIC = False,
    load: LOAD = None,
    mass: MASS = None,
    output: OUT = None,
    force: FORCE = False,
    plot: PLOT = None,
    as_json: JSON = False,
) -> None:
    """Play a recording as if it were a hand.

    Without --through its states go out on a bus at the time they were recorded. With --through they go over a
    CAN bus in this process to the grasp_force node, in simulated time, and a summary of what it said follows.

    Example: vegrip sample press && vegrip replay press --through --plot press.png
    """
    from vegrip.errors import UsageError

    if through:
        if speed != 1.0 or config is not None:
            raise UsageError(
                "--through runs in simulated time on a bus of its own; leave out --speed and --config"
            )
        if load is not None and mass is not None:
            raise UsageError("--load and --mass both state the load; leave one out")
        stated = _Load(load, mass)
        _run_through(recording, finger, parameters, not classic, stated, output, force, plot, as_json)
    elif parameters or classic or output or plot or as_json or load is not None or mass is not None:
        raise UsageError(
            "--parameters, --classic, --load, --mass, --output, --plot and --json belong to --through; add it"
        )
    else:
        _play(recording, config, finger, speed, values or [])


@dataclass(frozen=True)
class _Load:
    """A load that is stated where none is measured: of each finger [N], or a mass [kg] between them."""

    force: float | None
    mass: float | None

    def put_on(self, fingers: "dict[str, Recording]") -> "dict[str, Recording]":
        from vegrip.identification.sensors import share_of, with_load

        force = self.force if self.mass is None else share_of(self.mass, len(fingers))
        return fingers if force is None else {name: with_load(each, force) for name, each in fingers.items()}


def _play(recording: Path, config: Path | None, finger: str, speed: float, values: list[str]) -> None:
    import dataclasses

    from vegrip.cli.node import configured
    from vegrip.runtime.process import run_node

    _recordings(recording, finger)  # what cannot be read is refused before the bus is opened
    node = configured("replay", config, None, None, values)
    played = {"recording": str(recording), "finger": finger, "speed": speed}
    run_node(dataclasses.replace(node, parameters={**node.parameters, **played}))


def _run_through(
    folder: Path,
    finger: str,
    parameters: Path | None,
    fd: bool,
    stated: "_Load",
    output: Path | None,
    force: bool,
    plot: Path | None,
    as_json: bool,
) -> None:
    import tempfile

    from vegrip.cli._fits import print_sentences
    from vegrip.cli._outcome import print_outcome
    from vegrip.cli._progress import progress
    from vegrip.errors import DeviceError
    from vegrip.identification.recording.traces import replaced
    from vegrip.identification.recording.writer import RecordingWriter
    from vegrip.identification.sensors import LOAD_REMEDY, lacking
    from vegrip.runtime.replay.grasp import grasp_node, offline, read_settings
    from vegrip.runtime.replay.run import run_through

    if output is not None:
        claim_recording(output, force=force)
    recordings = stated.put_on(_recordings(folder, finger))
    pictures = {name: _beside(plot, name, len(recordings)) for name in recordings} if plot else {}
    node = grasp_node(offline(read_settings(parameters)), recordings)
    with Outputs(force=force) as outputs, tempfile.TemporaryDirectory() as scratch:
        for picture in pictures.values():
            outputs.picture(picture)
        session = output or Path(scratch) / "session"
        tip, sensors = _sensors(recordings)
        with progress("replay") as report, replaced(session):
            report(f"runs the node over {', '.join(recordings)}")
            with RecordingWriter(session, radius=tip, sensors=sensors) as writer:
                outcome = run_through(node, recordings, writer=writer, fd=fd)
            if writer.problem:
                raise DeviceError(writer.problem)
        for name, picture in pictures.items():
            outputs.write(picture, partial(_draw, session / name, f"{folder.name}, {name}"))
        if as_json:
            typer.echo(json.dumps({"recording": str(folder), **outcome.as_dict()}))
        else:
            print_outcome(outcome, {name: each.report for name, each in recordings.items()})
            for name, each in recordings.items():
                print_sentences(f"{name}: {sentence}" for sentence in lacking(each.columns, LOAD_REMEDY))


def _sensors(recordings: "dict[str, Recording]") -> "tuple[float, Mapping[str, float]]":
    """Return radius and noise of the first finger: a session states one of each."""
    one = next(iter(recordings.values()))
    return one.fingertip.radius, one.sensors


def _draw(session: Path, title: str, picture: Path) -> None:
    from vegrip.runtime.replay.plot import draw_replay

    draw_replay(session, picture, title)


def _recordings(folder: Path, finger: str) -> "dict[str, Recording]":
    from vegrip.errors import UsageError
    from vegrip.identification.recording.session import read_fingers

    found = read_fingers(folder, announce=False)
    if not finger:
        return found
    if len(found) != 1:
        raise UsageError(f"--finger renames a single recording; {folder} has {', '.join(found)}")
    return {finger: next(iter(found.values()))}


def _beside(plot: Path, finger: str, count: int) -> Path:
    return plot if count == 1 else plot.with_stem(f"{plot.stem}-{finger}")
