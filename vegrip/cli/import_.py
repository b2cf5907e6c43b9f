"""``vegrip import``: any table of numbers, or a CAN log, becomes a recording."""

import json
import math
from pathlib import Path
from typing import Annotated

import typer

SRC = Annotated[Path, typer.Argument(help="Table (CSV, also .gz) or CAN log (.asc, .blf) to read.")]
OUT = Annotated[Path, typer.Option("-o", "--output", help="Folder to write the recording to.")]
MAP_FILE = Annotated[Path | None, typer.Option(help="Column map (TOML), see examples/maps.")]
MAP = Annotated[list[str] | None, typer.Option("--map", help="CHANNEL=COLUMN, e.g. normal_force=force_N.")]
UNIT = Annotated[list[str] | None, typer.Option("--unit", help="CHANNEL=UNIT, e.g. displacement=mm.")]
RADIUS = Annotated[str, typer.Option(help="Radius of the fingertip, e.g. '8 mm'; overrides the map's.")]
FINGERS = Annotated[str, typer.Option(help="CAN logs: fingers in the order of the bus, by commas.")]
JSON = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


def import_(
    src: SRC,
    output: OUT,
    map_file: MAP_FILE = None,
    columns: MAP = None,
    units: UNIT = None,
    radius: RADIUS = "",
    fingers: FINGERS = "thumb,index,middle,ring,little",
    as_json: JSON = False,
) -> None:
    """Turn a table or a CAN log into a recording: SI units, checked, every bad row reported by its line.

    Example: vegrip import press.csv -o press --map t=time_s --map normal_force=F --unit normal_force=mN
    """
    from vegrip.cli._recordings import describe, print_recording
    from vegrip.recording import Recording, write_recording
    from vegrip.recording.column_map import ColumnMap, read_column_map, with_columns
    from vegrip.recording.import_csv import import_csv
    from vegrip.recording.units import parse_length

    metres = parse_length(radius, "--radius") if radius else math.nan
    folders: dict[Path, Recording] = {}
    if src.suffix.lower() in (".asc", ".blf"):
        from vegrip.recording.can_log import read_can_log

        for finger, recording in read_can_log(src, fingers.split(","), radius=metres).items():
            folders[output / finger] = recording
    else:
        chart = read_column_map(map_file) if map_file else ColumnMap()
        folders[output] = import_csv(src, with_columns(chart, columns or [], units or []), radius=metres)
    for folder, recording in folders.items():
        write_recording(recording, folder)
    if as_json:
        found = [{"folder": str(folder), **describe(each)} for folder, each in folders.items()]
        typer.echo(json.dumps({"recordings": found}))
        return
    for folder, recording in folders.items():
        print_recording(recording, folder)
