"""The tables of a recording or session, as text, on their way into an MCAP file."""

import logging
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.folder import TOML, read_recording
from vegrip.identification.recording.mcap_cells import properties
from vegrip.identification.recording.report import LoadReport
from vegrip.identification.recording.rows import FILES
from vegrip.identification.recording.table import Layout, read_header, read_table
from vegrip.messages import FingertipState, Message, NodeStatus
from vegrip.transport.codec.schema import message_set
from vegrip.transport.codec.topics import PLACE

LIMIT: Final = 2**62
"""[ns] Stamps beyond this (146 years) are refused: they do not fit the format together with a start."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class TextTable:
    """One table: where it lies in the folder, on which topic it goes, and its rows with their stamps [ns]."""

    file: str
    topic: str
    kind: type[Message]
    columns: tuple[str, ...]
    stamps: list[int]
    rows: list[Sequence[str]]


def finger_folders(folder: Path) -> list[Path]:
    """Return the folders that hold a recording: ``folder`` itself, or those of a session in it.

    Raises:
        RecordingError: there is none.

    """
    if (folder / TOML).exists():
        return [folder]
    found = sorted(path.parent for path in folder.glob(f"*/{TOML}"))
    if not found:
        raise RecordingError(f"{folder}: holds no recording; a recording is a folder with {TOML}")
    return found


def tables_of(folder: Path, recordings: dict[Path, Recording]) -> Iterator[TextTable]:
    """Yield every table in ``folder``; ``recordings`` by their folder, read already."""
    start = 0
    for place, recording in recordings.items():
        start = recording.start
        yield _measured(folder, place, recording)
        for kind, name in FILES.items():
            path = place / name
            if kind not in (FingertipState, NodeStatus) and path.exists():
                yield _said(folder, path, kind, recording.fingertip.name, start)
    path = folder / FILES[NodeStatus]
    if path.exists():
        yield _said(folder, path, NodeStatus, "", start)


def read_all(folder: Path) -> dict[Path, Recording]:
    """Return the recordings in ``folder`` by the folder of each."""
    return {place: read_recording(place, announce=False) for place in finger_folders(folder)}


def _measured(folder: Path, place: Path, recording: Recording) -> TextTable:
    numbers = [recording.t, recording.episode, *recording.columns.values()]
    cells = [[_text(value) for value in column.tolist()] for column in numbers]
    stamps = [_stamp(t, recording.start, str(place)) for t in recording.t.tolist()]
    file = (place / FILES[FingertipState]).relative_to(folder).as_posix()
    columns = ("t", "episode", *recording.columns)
    topic = _topic(FingertipState, recording.fingertip.name)
    return TextTable(file, topic, FingertipState, columns, stamps, list(zip(*cells, strict=True)))


def _said(folder: Path, path: Path, kind: type[Message], finger: str, start: int) -> TextTable:
    layout, report = Layout(sealed=True), LoadReport()
    columns = tuple(read_header(path, layout))
    unknown = sorted(set(columns) - set(properties(kind)))
    if unknown or "t" not in columns:
        raise RecordingError(f"{path}: " + (f"unknown column {unknown[0]!r}" if unknown else "no column 't'"))
    words = read_table(path, [], columns, layout, report).words
    report.rows_kept = len(words["t"])
    if report.rows_lost:
        log.warning("%s: %s", path, report.summary())
    stamps = [_stamp(_seconds(path, t), start, str(path)) for t in words["t"]]
    rows: list[Sequence[str]] = list(zip(*(words[name] for name in columns), strict=True))
    return TextTable(path.relative_to(folder).as_posix(), _topic(kind, finger), kind, columns, stamps, rows)


def _topic(kind: type[Message], finger: str) -> str:
    return message_set().messages[kind].topic.replace(PLACE, finger)


def _text(value: float) -> str:
    return "" if math.isnan(value) else repr(value)


def _seconds(path: Path, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise RecordingError(f"{path}: the time {text!r} is not a number") from None


def _stamp(t: float, start: int, what: str) -> int:
    if not abs(t) * NS < LIMIT or not abs(start) < LIMIT:
        raise RecordingError(f"{what}: the time {t!r} s is too large for an MCAP file")
    return start + round(t * NS)
