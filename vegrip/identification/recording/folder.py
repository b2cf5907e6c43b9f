"""Recordings on disk: a folder with ``recording.toml`` and ``recording.csv`` or ``recording.csv.gz``."""

import contextlib
import gzip
import logging
import math
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.config import build, read_toml, toml_value
from vegrip.errors import ConfigError, RecordingError, suggestion
from vegrip.identification.recording.channels import NOISE_NAMES, RECORDED
from vegrip.identification.recording.checks import kept_rows
from vegrip.identification.recording.data import MATERIAL, Fingertip, Recording
from vegrip.identification.recording.report import DOUBTS, MISSING, Kind, LoadReport, describe_missing
from vegrip.identification.recording.table import BLOCK_ROWS, Layout, Progress, read_header, read_table
from vegrip.types import Floats
from vegrip.whole_file import filled_folder, whole_file, writing

TOML = "recording.toml"
CSV = "recording.csv"
KEYS = ("name", "start", "fingertip", "sensors", "source")  # of recording.toml
HEADING = "# All columns of recording.csv are SI units; temperature is in degrees Celsius."

log = logging.getLogger(__name__)


def existing_folder(folder: Path) -> Path:
    """Return ``folder``; what is none raises a :class:`RecordingError` with the remedy."""
    if folder.is_file():
        made = f"{shlex.quote(str(folder))} -o {shlex.quote(folder.name.partition('.')[0])}"
        remedy = f": make one with `vegrip import {made}`" if folder.suffix != ".toml" else ""
        if folder.name in {TOML, CSV, f"{CSV}.gz"}:
            remedy = f": give {folder.parent}"
        raise RecordingError(f"{folder}: is a file; a recording is a folder{remedy}")
    if not folder.is_dir():
        raise RecordingError(
            f"{folder}: there is no such folder; a recording is a folder with {TOML} and {CSV}"
        )
    return folder


def read_recording(
    folder: Path | str, *, announce: bool = True, progress: Progress = lambda _: None
) -> Recording:
    """Read the recording in ``folder``; what was left out and doubted is logged as warnings.

    Args:
        folder: holds ``recording.toml`` and ``recording.csv[.gz]``.
        announce: log doubts and rows left out (a caller that shows the report itself says no).
        progress: called with the number of rows read so far, now and then.

    Raises:
        RecordingError: missing, damaged or without a usable row; names file, line and remedy.

    """
    folder = existing_folder(Path(folder))
    fingers = sorted(one.parent.name for one in folder.glob(f"*/{TOML}"))
    if fingers and not (folder / TOML).exists():
        raise RecordingError(f"{folder}: holds the recordings {', '.join(fingers)}; give one of them")
    about = _about(folder / TOML)
    report = LoadReport()
    fingertip, sensors = _fingertip(folder, about, report), _sensors(folder, about)
    t, episode, columns = _measurements(_csv(folder), fingertip.radius, report, progress)
    _note_unused(folder, about, KEYS, report)
    name, start, source = about.get("name", folder.name), about.get("start", 0), about.get("source", {})
    if not isinstance(name, str) or not isinstance(start, int) or not isinstance(source, Mapping):
        raise RecordingError(f"{folder / TOML}: name must be text, start whole nanoseconds, source a table")
    missing = source.get(MISSING)
    if isinstance(missing, int) and missing > 0:
        report.add(Kind.NOTE, describe_missing(missing))
    if announce:
        kept = _kept_doubts(source)  # of the import, in one text
        for doubt in [*kept, *(one for one in report.doubts if not any(one in text for text in kept))]:
            log.warning("%s: %s", folder, doubt)
        if report.rows_lost:
            log.warning("%s: %s", folder, report.summary())
    return Recording(name, t, episode, columns, fingertip, sensors, source, start, report)


def _kept_doubts(source: Mapping[str, Any]) -> list[str]:
    stated = source.get(DOUBTS, ())
    return [str(one) for one in stated] if isinstance(stated, list | tuple) else [str(stated)]


def write_recording(recording: Recording, folder: Path | str, *, compressed: bool = False) -> None:
    """Write ``recording`` so that reading it gives the same numbers, bit for bit; the folder is made.

    Raises:
        RecordingError: it cannot be written; what was in the folder stays.

    """
    folder = Path(folder)
    name, other = (f"{CSV}.gz", CSV) if compressed else (CSV, f"{CSV}.gz")
    with writing(folder, RecordingError):
        with filled_folder(folder), whole_file(folder / TOML) as about, whole_file(folder / name) as table:
            about.write_text(toml_text(recording), encoding="utf-8")
            with table.open("wb") as raw:
                packed = gzip.GzipFile("", "wb", fileobj=raw, mtime=0) if compressed else None
                with packed or contextlib.nullcontext(raw) as file:
                    file.writelines(_csv_blocks(recording))
        (folder / other).unlink(missing_ok=True)


def _csv_blocks(recording: Recording) -> Iterator[bytes]:
    """Yield the table block by block; a block of columns is turned into text at once, which is quicker."""
    yield (",".join(("t", "episode", *recording.columns)) + "\n").encode()
    columns = (recording.t, recording.episode, *recording.columns.values())
    for start in range(0, len(recording), BLOCK_ROWS):
        cells = (repr(column[start : start + BLOCK_ROWS].tolist())[1:-1].split(", ") for column in columns)
        yield "".join(f"{row}\n" for row in map(",".join, zip(*cells, strict=True))).encode()


def toml_text(recording: Recording) -> str:
    """Return ``recording.toml``; an unknown radius is left out, and the file says so."""
    radius = recording.fingertip.radius
    lines = [HEADING, f"name = {toml_value(recording.name)}"]
    if recording.start:
        lines.append(f"start = {recording.start}  # [ns] stamp of t = 0 on the recorder's clock")
    lines += ["", "[fingertip]", f"name = {toml_value(recording.fingertip.name)}"]
    lines.append("# radius is unknown" if math.isnan(radius) else f"radius = {radius!r}  # [m]")
    lines += ["", "[sensors]  # standard deviation of the noise"]
    lines += [f"{name} = {std!r}" for name, std in recording.sensors.items()]
    if recording.source:
        lines += ["", "[source]"]
        lines += [f"{toml_value(key)} = {toml_value(value)}" for key, value in recording.source.items()]
    return "\n".join(lines) + "\n"


def _about(path: Path) -> dict[str, Any]:
    try:
        return read_toml(path)
    except ConfigError as error:
        raise RecordingError(f"{error}; a recording needs {TOML} with [fingertip] and [sensors]") from None


def _fingertip(folder: Path, about: Mapping[str, Any], report: LoadReport) -> Fingertip:
    table = dict(_section(folder, about, "fingertip"))
    for key in _note_unused(folder, table, ("radius", "name"), report):
        del table[key]
    if isinstance(table.get("radius"), float) and math.isnan(table["radius"]):
        del table["radius"]
    if "radius" not in table and MATERIAL not in about.get("source", {}):
        report.add(Kind.NOTE, "the fingertip's radius is unknown")
    try:
        return build(Fingertip, table, f"{folder / TOML} [fingertip]")
    except ConfigError as error:
        raise RecordingError(str(error)) from None


def _note_unused(
    folder: Path, table: Mapping[str, Any], known: tuple[str, ...], report: LoadReport
) -> list[str]:
    unused = sorted(table.keys() - known)
    for key in unused:
        said = f"{key!r} in {TOML} is not used; {suggestion(key, known, 'known are')}"
        report.add(Kind.NOTE, said)
        log.warning("%s: %s", folder, said)
    return unused


def _sensors(folder: Path, about: Mapping[str, Any]) -> dict[str, float]:
    sensors = {}
    for key, std in _section(folder, about, "sensors").items():
        where = f"{folder / TOML} [sensors]"
        if key not in NOISE_NAMES:
            raise RecordingError(
                f"{where}: unknown sensor {key!r}; {suggestion(key, NOISE_NAMES, 'known are')}"
            )
        if isinstance(std, bool) or not isinstance(std, int | float) or not 0.0 < std < math.inf:
            raise RecordingError(f"{where}: {key!r} is {std!r}; it must be a positive standard deviation, SI")
        sensors[key] = float(std)
    return sensors


def _section(folder: Path, about: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    section = about.get(name, {})
    if not isinstance(section, Mapping):
        raise RecordingError(f"{folder / TOML}: {name!r} must be a table, [{name}]")
    return section


def _csv(folder: Path) -> Path:
    found = [path for path in (folder / CSV, folder / f"{CSV}.gz") if path.exists()]
    if len(found) == 1:
        return found[0]
    if found:
        raise RecordingError(f"{folder}: holds both {CSV} and {CSV}.gz; remove one of them")
    raise RecordingError(f"{folder}: there is no {CSV} or {CSV}.gz; `vegrip import` makes one from any CSV")


def _measurements(
    path: Path, radius: float, report: LoadReport, progress: Progress
) -> tuple[Floats, NDArray[np.int64], dict[str, Floats]]:
    layout = Layout(sealed=True)
    header = read_header(path, layout)
    channels = [name for name in header if name in RECORDED]
    if not channels:
        raise RecordingError(
            f"{path}: none of the columns {', '.join(header)} is known ({', '.join(RECORDED)}); "
            "turn a foreign table into a recording with `vegrip import`"
        )
    for name in header:
        if name not in RECORDED and name not in ("t", "episode"):
            report.add(Kind.COLUMN, name)
    episode = ["episode"] if "episode" in header else []
    table = read_table(path, ["t", *episode, *channels], [], layout, report, progress)
    trial = table.numbers["episode"] if episode else np.zeros(len(table.lines))
    t = np.where(trial == np.rint(trial), table.numbers["t"], np.nan)  # no whole number: no trial
    columns = {name: table.numbers[name] for name in channels}
    whole = np.nan_to_num(trial).astype(np.int64)
    return kept_rows(path, t, whole, columns, radius, table.lines, report)
