"""A file of another kind becomes a recording, in one call: what ``vegrip import`` does, for Python."""

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

from vegrip.errors import InputError, KindError, RecordingError, UsageError
from vegrip.identification.recording.channels import STEP_QUANTITIES, noise_name
from vegrip.identification.recording.column_map import BaselineMap, ColumnMap, read_column_map, with_columns
from vegrip.identification.recording.data import Recording, join_recordings
from vegrip.identification.recording.folder import TOML
from vegrip.identification.recording.import_csv import import_csv
from vegrip.identification.recording.log_names import LOGS
from vegrip.identification.recording.table import Progress
from vegrip.identification.recording.touch import is_touch, read_touch
from vegrip.identification.recording.units import parse_length

BAGS: Final = (".bag", ".db3", ".mcap")  # and a folder, of rosbag 2
ARGUMENTS: Final = {
    "map-file": "map_file",
    "map": "columns:",
    "unit": "units:",
    "negate": "negate:",
    "zero": "zeros:",
    "radius": "radius",
    "baseline": "baseline",
    "accept-losses": "allow_losses",
}
"""What a remedy that names an option of ``vegrip import`` is called here."""
OPTION: Final = re.compile(rf"--({'|'.join(ARGUMENTS)})\b")


def import_recording(
    *paths: Path | str,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    radius: float | str | None = None,
    negate: str | Iterable[str] = (),
    zeros: Mapping[str, str] | None = None,
    noise: Mapping[str, float] | None = None,
    baseline: float | None = None,
    map_file: Path | str | None = None,
    allow_losses: bool = False,
) -> Recording:
    """Read a table (CSV and the like), touch data or a rosbag; several become episodes of one recording.

    Args:
        paths: the files.
        columns: channel -> column, ``{"normal_force": "force_mN", "t": "time_s", "episode": "trial"}``; a
            column that is called like a channel needs no word.
        units: channel -> unit, ``{"displacement": "mm"}``; SI when not given and not in the column's name.
        radius: of the fingertip [m], or with its unit, ``"8 mm"``.
        negate: channels whose sign is turned; compression is positive.
        zeros: channel -> where it is zero, ``{"displacement": "contact", "normal_force": "baseline"}``.
        noise: channel -> standard deviation of its white noise in SI, where that is known.
        baseline: how long each trial begins in the air [s].
        map_file: a map (TOML) of columns, with everything above and more.
        allow_losses: go on where a tenth of the rows is left out.

    Raises:
        KindError: a path is none.
        RecordingError: unreadable, a column is missing, a unit does not fit; names file, line and remedy.
        UsageError: there is no such channel, unit or kind of file.

    """
    if not paths:
        raise UsageError("import_recording wants the path of a table or rosbag, and was given none")
    chart = read_column_map(Path(map_file)) if map_file is not None else ColumnMap()
    turned = [negate] if isinstance(negate, str) else list(negate)
    chart = with_columns(chart, _pairs(columns), _pairs(units), turned, _pairs(zeros))
    if baseline is not None:
        chart = dataclasses.replace(chart, baseline=BaselineMap(baseline))
    metres = math.nan if radius is None else parse_length(str(radius), "radius")
    read = []
    for path in map(_checked, paths):
        try:
            read.append(_one(path, chart, metres))
            read[-1].report.refuse(path, accepted=allow_losses)
        except RecordingError as error:
            raise RecordingError(OPTION.sub(lambda found: ARGUMENTS[found[1]], str(error))) from None
    found = read[0] if len(read) == 1 else join_recordings(read, read[0].name)
    stated = {noise_name(channel): _std(channel, std) for channel, std in (noise or {}).items()}
    return dataclasses.replace(found, sensors={**found.sensors, **stated})


def _pairs(given: object) -> list[str]:
    if not isinstance(given, Mapping | None):
        kind = type(given).__name__
        raise KindError(
            f"import_recording wants a dict, {{'normal_force': 'force_N'}}, and was given a {kind}"
        )
    return [f"{channel}={name}" for channel, name in (given or {}).items()]


def _std(channel: str, given: object) -> float:
    if not isinstance(given, float | int) or not 0.0 < given < math.inf:
        raise KindError(f"the noise of {channel} is {given!r}; give its standard deviation in SI, above 0")
    return float(given)


def _checked(path: object) -> Path:
    if not isinstance(path, str | Path):
        kind = type(path).__name__
        raise KindError(
            f"import_recording wants the path of a table or rosbag, and was given a {kind}; of arrays "
            "vegrip.Recording(name, t, episode, columns, vegrip.Fingertip(radius)) is a recording"
        )
    found = Path(path)
    if not found.exists():
        raise InputError(f"{found}: there is no such file")
    if (found / TOML).is_file():
        raise RecordingError(
            f"{found}: is a recording already; vegrip.read_recording({str(path)!r}) reads it"
        )
    if found.suffix.lower() in LOGS:
        raise UsageError(
            f"{found}: is a CAN log of several fingers; `vegrip import {found} -o FOLDER` makes a recording "
            "of each, for vegrip.read_recording"
        )
    return found


def _one(path: Path, chart: ColumnMap, metres: float) -> Recording:
    found = read_file(path, chart, metres)
    if len(found) > 1:
        raise UsageError(
            f"{path}: is of the fingers {', '.join(found)}; `vegrip import {path} -o FOLDER` makes a "
            "recording of each, for vegrip.read_recording"
        )
    return next(iter(found.values()))


def read_file(
    path: Path,
    chart: ColumnMap,
    metres: float,
    *,
    is_step: bool = False,
    progress: Progress = lambda _: None,
) -> dict[str, Recording]:
    """Return the recordings in a table, bag or touch data, by finger; ``metres`` is the tips' radius."""
    if is_touch(path):
        return read_touch(path, chart, radius=metres)
    if path.is_dir() or path.suffix.lower() in BAGS:
        from vegrip.identification.recording.rosbag import import_rosbag  # noqa: PLC0415 (an extra)

        found = import_rosbag(path, chart, radius=metres)
    else:
        is_step = is_step or bool(STEP_QUANTITIES.keys() & chart.channels.keys())
        found = import_csv(path, chart, radius=metres, is_step=is_step, progress=progress)
    return {found.fingertip.name: found}
