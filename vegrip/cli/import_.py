"""``vegrip import``: a table, a CAN log, an MCAP file, a rosbag or touch data become a recording."""

import dataclasses
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, claim_file, claim_recording
from vegrip.cli._terminal import complain, counted, print_json, print_next, print_sentences, progress
from vegrip.errors import InputError, UsageError
from vegrip.text_encoding import encoding_of
from vegrip.whole_file import reading

if TYPE_CHECKING:
    from vegrip.identification.recording import Recording
    from vegrip.identification.recording.column_map import ColumnMap

SRC = Annotated[
    list[Path],
    typer.Argument(
        help="Table (CSV, also .gz), CAN log (.asc, .blf, .trc, .mf4, candump), .mcap, rosbag, or a "
        "recording to go to .mcap; touch data: a data set of LeRobot, HDF5 or .npz. "
        "Several tables or bags become the episodes of one recording."
    ),
]
OUT = Annotated[
    Path, typer.Option("-o", "--output", help="Folder to write the recording to; FILE.mcap writes MCAP.")
]
MAP_FILE = Annotated[Path | None, typer.Option(help="Map (TOML) of columns or topics, see examples/maps.")]
MAP = Annotated[list[str] | None, typer.Option("--map", help="CHANNEL=COLUMN, e.g. normal_force=force_N.")]
UNIT = Annotated[list[str] | None, typer.Option("--unit", help="CHANNEL=UNIT, e.g. displacement=mm.")]
NEGATE = Annotated[
    list[str] | None, typer.Option("--negate", help="Channel whose sign is turned; compression is positive.")
]
ZERO = Annotated[
    list[str] | None,
    typer.Option("--zero", help="CHANNEL=first, baseline or contact, e.g. displacement=contact."),
]
BASELINE = Annotated[
    float | None, typer.Option(min=0.0, help="Seconds without contact at the start of every trial.")
]
RADIUS = Annotated[str, typer.Option(help="Radius of the fingertip, e.g. '8 mm'; overrides the map's.")]
STEP = Annotated[
    bool,
    typer.Option("--step", help="A unit step held, without a contact: modulus or compliance against time."),
]
DELIMITER = Annotated[str, typer.Option(help="What separates the fields of a table, or tab; else found.")]
DECIMAL = Annotated[str, typer.Option(help="Decimal sign of a table, . or ,; else found.")]
THOUSANDS = Annotated[str, typer.Option(help="What stands between thousands, or none; else found.")]
SPREAD = Annotated[bool, typer.Option("--spread", help="Rows of one time stamp are spread until the next.")]
CHANNEL = Annotated[str, typer.Option(help="CAN logs of several channels: the one to read, e.g. can0.")]
FRAME = Annotated[str, typer.Option(help="Bags: frame_id of the messages to take, of a topic with several.")]
ACCEPT = Annotated[
    bool, typer.Option("--accept-losses", help="Go on where a tenth of the rows or more cannot be used.")
]
FINGERS = Annotated[str, typer.Option(help="CAN logs: fingers in the order of the bus, by commas.")]
CANDUMP = re.compile(r"\s*\(-?\d+(\.\d+)?\) \S+ [0-9A-Fa-f]+#| *(\(.*\) +)?\w+  +[0-9A-F]{3,8} +\[\d+\]")
ALL = "thumb,index,middle,ring,little"


def import_(
    src: SRC,
    output: OUT,
    force: FORCE = False,
    map_file: MAP_FILE = None,
    columns: MAP = None,
    units: UNIT = None,
    negated: NEGATE = None,
    zeros: ZERO = None,
    baseline: BASELINE = None,
    radius: RADIUS = "",
    step: STEP = False,
    delimiter: DELIMITER = "",
    decimal: DECIMAL = "",
    thousands: THOUSANDS = "",
    spread: SPREAD = False,
    channel: CHANNEL = "",
    frame: FRAME = "",
    accept: ACCEPT = False,
    fingers: FINGERS = ALL,
    as_json: JSON = False,
) -> None:
    """Turn a table, log, bag or touch data into a recording: SI units, checked, every bad row reported.

    Example: vegrip sample press.csv && vegrip import press.csv -o rig --map t=time_s --map episode=trial
    --map displacement=depth_mm --unit displacement=mm --map normal_force=force_mN --unit normal_force=mN
    --radius 8mm

    A CAN log needs no map: vegrip sample press.blf && vegrip import press.blf -o log --fingers thumb

    Of a data set of LeRobot by others: --map normal_force=observation.state[6] --unit normal_force=mN
    """
    from vegrip.identification.recording import column_map
    from vegrip.identification.recording.channels import STEP_QUANTITIES, STRETCHES
    from vegrip.identification.recording.import_file import BAGS
    from vegrip.identification.recording.touch import is_touch
    from vegrip.identification.recording.units import parse_length

    metres = parse_length(radius, "--radius") if radius else math.nan
    one = src[0]
    of_logs: dict[str, object] = {"--channel": channel}
    of_frames: dict[str, object] = {"--frame": frame}
    form: dict[str, object] = {"--decimal": decimal, "--thousands": thousands, "--delimiter": delimiter}
    of_tables = {"--step": step} | form
    of_maps: dict[str, object] = {"--map": columns, "--unit": units, "--negate": negated}
    of_maps |= {"--map-file": map_file, "--zero": zeros, "--baseline": baseline}
    mapped = map_file is not None or bool(columns)
    is_mcap = output.suffix.lower() == ".mcap" or (one.suffix.lower() == ".mcap" and not mapped)
    _check_sources(src, output, is_mcap=is_mcap)
    if is_mcap:
        alone = of_maps | of_tables | {"--spread": spread} | of_logs | of_frames | {"--radius": radius}
        _refuse_options(alone, "a recording in MCAP, which describes itself")
    elif is_touch(one):
        _refuse_options(of_tables | of_logs | of_frames, "touch data")
    elif _is_can_log(one):
        _refuse_options(
            of_maps | of_tables | of_frames, "a CAN log, which is read by the message set of vegrip"
        )
    elif one.is_dir() or one.suffix.lower() in BAGS:
        _refuse_options(of_logs, "a bag")
    else:
        _refuse_options(of_logs | of_frames, "a table")
    _claim(output, one, fingers, force=force)
    has_own_zeros = False
    if is_mcap:
        found = _mcap(one, output)
    elif _is_can_log(one):
        found = _can_log(one, output, fingers, metres, channel, spread=spread, accepted=accept)
    else:
        if decimal not in ("", ".", ","):
            raise UsageError(f"--decimal is {decimal!r}; it is . or ,")
        chart = column_map.read_column_map(map_file) if map_file else column_map.ColumnMap()
        chart = column_map.with_columns(chart, columns or [], units or [], negated or [], zeros or [])
        form["--delimiter"] = {"tab": "\t"}.get(delimiter, delimiter)
        chart = dataclasses.replace(
            chart,
            table=_with(chart.table, {name[2:]: value for name, value in form.items()}),
            bag=_with(chart.bag, {"frame": frame}),
            time=_with(chart.time, {"spread": spread}),
            baseline=_with(chart.baseline, {"duration": baseline}),
        )
        has_own_zeros = any(entry.zero == "contact" for entry in chart.channels.values())
        is_step = step or bool(STEP_QUANTITIES.keys() & chart.channels.keys())
        if radius and (is_step or STRETCHES.keys() & chart.channels.keys()):
            raise UsageError("--radius does not apply to a material without a contact")
        if zeros and is_step:
            raise UsageError("--zero does not apply to a step, whose zeros are known")
        found = _mapped(src, output, chart, metres, is_step=is_step, accepted=accept, force=force)
    _print_result(found, has_own_zeros=has_own_zeros, as_json=as_json)


T = TypeVar("T")


def _with(section: T, said: Mapping[str, Any]) -> T:
    """Return a section of the map with what was said as an option."""
    given = {key: value for key, value in said.items() if value not in (None, "", False)}
    changed: T = dataclasses.replace(section, **given)  # type: ignore[type-var]
    return changed


def _is_can_log(path: Path) -> bool:
    """Return whether it is one by its name, or one of candump by its first line."""
    from vegrip.identification.recording.log_names import LOGS, LOGS_OR_CANDUMP

    if path.suffix.lower() in LOGS:
        return True
    if path.suffix.lower() == ".gz" and Path(path.stem).suffix.lower() in LOGS_OR_CANDUMP:
        return True
    if not path.is_file():
        return False
    with reading(path), path.open("rb") as file:
        head = file.read(400)
    return CANDUMP.match(head.decode(encoding_of(head), errors="replace")) is not None


def _check_sources(src: list[Path], output: Path, *, is_mcap: bool) -> None:
    from vegrip.identification.recording.folder import existing_folder
    from vegrip.identification.recording.touch import is_touch

    if len(src) > 1 and (is_mcap or any(_is_can_log(each) or is_touch(each) for each in src)):
        raise UsageError("only tables and mapped bags can be joined; import all else one by one")
    if output.suffix.lower() == ".mcap":
        existing_folder(src[0])


def _claim(output: Path, src: Path, fingers: str, *, force: bool) -> None:
    if output.suffix.lower() == ".mcap":
        claim_file(output, force=force)
    elif _is_can_log(src):
        for finger in fingers.split(","):
            claim_recording(output / finger, force=force)
    else:
        claim_recording(output, force=force)


def _mcap(src: Path, output: Path) -> "Mapping[Path, Recording]":
    from vegrip.identification.recording.mcap import read_mcap, write_mcap
    from vegrip.identification.recording.session import replaced

    if output.suffix.lower() == ".mcap":
        return write_mcap(src, output)
    with replaced(output):
        return read_mcap(src, output)


def _can_log(
    src: Path,
    output: Path,
    fingers: str,
    radius: float,
    channel: str,
    *,
    spread: bool,
    accepted: bool,
) -> "Mapping[Path, Recording]":
    from vegrip.identification.recording.can_log import read_can_log

    found = read_can_log(src, fingers.split(","), radius=radius, channel=channel, spread=spread)
    for finger in fingers.split(",") if fingers != ALL else ():
        if finger not in found:
            complain(f"{src}: no state of {finger} is in it; --fingers names them in the order of the bus")
    for finger, recording in found.items():
        recording.report.refuse(f"{src}: {finger}", accepted=accepted)
    return _written({output / finger: recording for finger, recording in found.items()})


def _mapped(
    src: list[Path],
    output: Path,
    chart: "ColumnMap",
    radius: float,
    *,
    is_step: bool,
    accepted: bool,
    force: bool,
) -> "Mapping[Path, Recording]":
    from vegrip.identification.recording.data import join_recordings
    from vegrip.identification.recording.import_file import BAGS, read_file

    recordings: list[Recording] = []
    for path in src:
        if path.is_dir() and not any(path.iterdir()):
            raise InputError(f"{path}: is an empty folder; give a table, a CAN log or a rosbag")
        if is_step and (path.is_dir() or path.suffix.lower() in BAGS):
            raise UsageError(f"{path}: --step does not apply to a rosbag; give a table")
        with progress("import") as report:
            found = read_file(path, chart, radius, is_step=is_step, progress=counted(report))
        for one in found.values():
            one.report.refuse(path, accepted=accepted)
        recordings += found.values()
    if len(src) > 1:
        recordings = [join_recordings(recordings, output.name)]
    if len(recordings) == 1:
        return _written({output: recordings[0]})
    for finger in found:
        claim_recording(output / finger, force=force)
    return _written({output / finger: recording for finger, recording in found.items()})


def _written(found: "Mapping[Path, Recording]") -> "Mapping[Path, Recording]":
    from vegrip.identification.recording import write_recording
    from vegrip.identification.recording.report import DOUBTS
    from vegrip.identification.recording.session import replaced

    for folder, recording in found.items():
        doubts = list(dict.fromkeys([*recording.report.warnings(), *recording.report.doubts]))
        source = {**recording.source, **({DOUBTS: "; ".join(doubts)} if doubts else {})}
        with replaced(folder):
            write_recording(dataclasses.replace(recording, source=source), folder)
    return found


def _refuse_options(options: Mapping[str, object], what: str) -> None:
    for name, value in options.items():
        if value:
            raise UsageError(f"{name} does not apply to {what}")


def _print_result(found: "Mapping[Path, Recording]", *, has_own_zeros: bool, as_json: bool) -> None:
    from vegrip.cli._recordings import print_recording
    from vegrip.display.recording import describe
    from vegrip.identification.fit.preprocess import lacking_rows
    from vegrip.identification.recording import Kind
    from vegrip.identification.recording.report import account

    for folder, recording in found.items():
        for sentence in recording.report.warnings():
            complain(f"{folder}: {sentence}")
    if as_json:
        result = [{"folder": str(folder), **describe(recording)} for folder, recording in found.items()]
        print_json({"recordings": result, "rows": account(one.report for one in found.values())})
        return
    for folder, recording in found.items():
        print_recording(recording, folder)
    folder, recording = next(iter(found.items()))
    is_suspect = any(
        finding.kind in {Kind.SUSPECT, Kind.IMPLAUSIBLE} for finding in recording.report.findings
    )
    if folder.is_dir() and not is_suspect:
        has_both = {"displacement", "normal_force"} <= recording.columns.keys()
        is_fit = has_both and (recording.fingertip.radius > 0.0 or recording.is_material)
        each = ["--zeros-each-episode"] if has_own_zeros and recording.episode[-1] > 0 else []
        if is_fit and (lacking := lacking_rows(recording)):
            print_sentences([f"not enough for a fit: {lacking}"])
            return
        print_next("vegrip", *(("fit", folder, *each) if is_fit else ("replay", folder, "--through")))
