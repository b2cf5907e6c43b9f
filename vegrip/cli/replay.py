"""``vegrip replay``: play a recording on a bus, or run the node over it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import SET
from vegrip.cli._outputs import FORCE, Outputs, claim_recording
from vegrip.cli._terminal import complain, print_json, print_sentences, printer, progress
from vegrip.clock import WallClock
from vegrip.config import build
from vegrip.display.text import figures
from vegrip.errors import DeviceError, InputError, UsageError

if TYPE_CHECKING:
    from vegrip.identification.recording import LoadReport, Recording
    from vegrip.runtime.replay.run import Outcome

RECORDING = Annotated[
    Path,
    typer.Argument(
        help="Folder of a recording or of a session; or a CAN log (.blf, .asc, .trc, .mf4, .mdf, or .log of "
        "candump) with --map."
    ),
]
CONFIG = Annotated[
    Path | None,
    typer.Option(
        "--config",
        "--map",
        help="Launch file with a node `replay`, to take its bus from; for a log the map of its hand, "
        "with its bus, or a launch file that names one.",
    ),
]
OUTCOME_ROWS = (
    ("samples", "samples", ""),
    ("in contact", "contact_time", " s"),
    ("force, estimate against measured, rms", "force_rms", " N"),
    ("mean normalised innovation squared", "nis", ""),
    ("consistent, of the health reports with a verdict", "consistent", ""),
    ("measurements refused as outliers", "rejected", ""),
    ("commands", "commands", ""),
    ("highest command", "highest_command", " N"),
)
BELOW_0 = "below 0: a slip was possible"
PATIENCE_S = 1.0  # for which a frame waits for room on the bus
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
    typer.Option(
        "--mass", min=0.0, help="With --through: mass that the fingers hold [kg], shared evenly, for --load."
    ),
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
    """Play a recording, or the log of a hand of another make, as if it were a hand.

    Without --through its states, or frames, go out on a bus at the time they were recorded. With --through
    they go over a CAN bus in this process to the grasp_force node, in simulated time, and a summary of what
    it said follows. A log goes to a node that runs: --map hand.toml says what in it is the hand's.

    Example: vegrip sample press && vegrip replay press --through --plot press.png
    """
    from vegrip.identification.recording.log_names import LOGS_OR_CANDUMP

    if recording.suffix.lower() in LOGS_OR_CANDUMP and not recording.is_dir():
        if through or finger:
            raise UsageError("a log is played as it is; leave out --through and --finger")
        _play_log(recording, config, speed, values or [])
    elif through:
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

    def assumed(self, fingers: "dict[str, Recording]") -> str:
        """Return what is taken of the load of fingers that do not feel theirs, empty where all do."""
        from vegrip.identification.sensors import TANGENTIAL_CHANNELS, share_of

        unfelt = [name for name, one in fingers.items() if not set(TANGENTIAL_CHANNELS) <= set(one.columns)]
        if self.mass is None or not unfelt:
            return ""
        return (
            f"{', '.join(unfelt)} taken to bear an even share of {self.mass:g} kg, "
            f"{share_of(self.mass, len(fingers)):.3g} N each: one that bears more slips earlier than stated; "
            "state the largest share by --load"
        )

    def applied_to(self, fingers: "dict[str, Recording]") -> "dict[str, Recording]":
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


def _play_log(log: Path, config: Path | None, speed: float, values: list[str]) -> None:
    import can

    from vegrip.cli.node import assigned
    from vegrip.identification.recording.can_frames import read_log
    from vegrip.runtime.launch_file import find_launch_file, read_launch_file
    from vegrip.runtime.replay.run import play_frames
    from vegrip.transport.mapped.codec import MappedCodec
    from vegrip.transport.mapped.plan import open_plan
    from vegrip.transport.open import CanSettings, open_bus

    if not log.is_file():
        raise InputError(f"{log}: there is no such file")
    nodes = [] if config is None else read_launch_file(find_launch_file(str(config)))
    table = {"transport": next((dict(node.transport) for node in nodes if node.transport.get("map")), {})}
    if not table["transport"]:
        raise UsageError(
            f"{log} is a log: give the map of its hand, or a launch file that names one, by --map; frames of "
            f"our own layout become a recording first: vegrip import {log} -o NAME"
        )
    for assignment in values:
        assigned(table, assignment)
    settings = build(CanSettings, table["transport"], f"{config} [transport]")
    codec = MappedCodec(open_plan(settings.map))
    own = codec.identifiers
    of_map = str(table["transport"].get("channel", ""))
    read = read_log(log, extended=True, channel=of_map, wanted=own, remedy="transport.channel={0}")
    own_frames = [frame for frame in read.frames if frame.arbitration_id in own]
    for sentence in read.report.warnings():
        complain(f"{log}: {sentence}")
    if not own_frames:
        raise UsageError(f"{log}: none of its frames is one that {settings.map} reads")
    bus, _, _ = open_bus(settings)
    try:
        count = play_frames(own_frames, lambda frame: bus.send(frame, timeout=PATIENCE_S), WallClock(), speed)
    except can.CanError as error:
        raise DeviceError(f"{log} is not played to its end: {error}") from None
    finally:
        bus.shutdown()
    typer.echo(f"played {count} frames of {', '.join(codec.plan.messages)} on {settings.channel}")


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

    from vegrip.identification.recording.session import replaced
    from vegrip.identification.recording.writer import RecordingWriter
    from vegrip.identification.sensors import LOAD_REMEDY, lacking
    from vegrip.runtime.replay.run import grasp_node, offline, read_settings, run_through

    if output is not None:
        claim_recording(output, force=force)
    read = _recordings(folder, finger)
    recordings, assumed = stated.applied_to(read), stated.assumed(read)
    pictures = {name: _beside(plot, name, len(recordings)) for name in recordings} if plot else {}
    node = grasp_node(offline(read_settings(parameters)), recordings)
    with Outputs(force=force) as outputs, tempfile.TemporaryDirectory() as scratch:
        for picture in pictures.values():
            outputs.picture(picture)
        session = output or Path(scratch) / "session"
        first = next(iter(recordings.values()))  # a session states one radius and one noise
        with progress("replay") as report, replaced(session):
            report(f"runs the node over {', '.join(recordings)}")
            with RecordingWriter(session, radius=first.fingertip.radius, sensors=first.sensors) as writer:
                outcome = run_through(node, recordings, writer=writer, fd=fd)
            if writer.problem:
                raise DeviceError(writer.problem)
        for name, picture in pictures.items():
            outputs.write(picture, partial(_draw, session / name, f"{folder.name}, {name}"))
        if as_json:
            print_json({"recording": str(folder), "assumed": assumed, **outcome.as_dict()})
        else:
            _print_outcome(outcome, {name: each.report for name, each in recordings.items()})
            print_sentences([assumed] if assumed else [])
            for name, each in recordings.items():
                print_sentences(f"{name}: {sentence}" for sentence in lacking(each.columns, LOAD_REMEDY))


def _draw(session: Path, title: str, picture: Path) -> None:
    from vegrip.runtime.replay.plot import draw_replay

    draw_replay(session, picture, title)


def _recordings(folder: Path, finger: str) -> "dict[str, Recording]":
    from vegrip.identification.recording.session import read_fingers

    found = read_fingers(folder, announce=False)
    if not finger:
        return found
    if len(found) != 1:
        raise UsageError(f"--finger renames a single recording; {folder} has {', '.join(found)}")
    return {finger: next(iter(found.values()))}


def _beside(plot: Path, finger: str, count: int) -> Path:
    return plot if count == 1 else plot.with_stem(f"{plot.stem}-{finger}")


def _print_outcome(outcome: "Outcome", reports: "Mapping[str, LoadReport]") -> None:
    console = printer()
    result = outcome.as_dict()["fingers"]
    table = figures("", *result, left=("",))
    for title, key, unit in OUTCOME_ROWS:
        table.add_row(title, *(_number(each[key], unit) for each in result.values()))
    bounds = (each["lowest_margin_bound"] for each in result.values())
    table.add_row("lowest margin bound", *(BELOW_0 if (b or 0.0) < 0.0 else _number(b, "") for b in bounds))
    for title, key in (("input", "conditions"), ("fails", "failing"), ("suspect", "suspects")):
        if key == "suspects" and not any(each[key].keys() - {"none"} for each in result.values()):
            continue  # none was looked for
        table.add_row(title, *(_first(each[key]) for each in result.values()))
    for title, key in (("pressure exponent", "pressure_exponent"), ("friction", "friction_coefficient")):
        table.add_row(f"{title}, last", *(_estimate(each[key]) for each in result.values()))
    console.print(table)
    for finger, report in reports.items():
        if report.findings:
            console.print(f"recording of {finger}: {report.summary()}")
    for name, count in outcome.rejected.items():
        console.print(f"refused on the bus or in the node: {name} ({count} x)")


def _number(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.4g}{unit}"


def _first(counts: Mapping[str, int]) -> str:
    total = sum(counts.values())
    return ", ".join(f"{name} {count / total:.0%}" for name, count in list(counts.items())[:2]) or "-"


def _estimate(estimate: Mapping[str, Any]) -> str:
    if estimate["value"] is None:
        return "-"
    doubt = "" if estimate["valid"] else " (not valid)"
    return f"{estimate['value']:.3g} +- {_number(estimate['std'], '')}{doubt}"
