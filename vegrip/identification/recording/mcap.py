"""Recordings and sessions as one MCAP file, a channel of JSON messages per table, and back.

::

    attachment thumb/recording.toml     the descriptions, as they stand in the folder
    channel /hand/thumb/state           recording.csv; jsonschema vegrip.FingertipState
    channel /hand/thumb/contact         contact.csv and so on, on the topics of proto/messages.toml

The channel's metadata say which file it was and in which order its columns stood; the sequence of a message
is its row. ``log_time`` is the stamp of the message on the recorder's clock.

A number goes over as the text it is written with, so that it comes back with every digit. Two rules make up
for what JSON lacks: an empty cell (not measured) is left out, and infinity is ``1e999``, which is a number by
JSON's grammar and which Python and JavaScript read as infinity.
"""

import heapq
import json
import re
import struct
import tempfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import IntFlag
from pathlib import Path, PurePath
from typing import Any, Final

from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.folder import TOML, read_recording, toml_text
from vegrip.identification.recording.rosbag import bag_library
from vegrip.identification.recording.session import finger_folders, read_cells
from vegrip.identification.recording.writer import FILE_OF_MESSAGE, SESSION, exact_cell
from vegrip.messages import OF_NODES, FingertipState, Message
from vegrip.transport.codec.schema import PLACE, Field, message_set
from vegrip.whole_file import reading, whole_file, write_whole, writing

NUMBER: Final = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][+-]?\d+)?")
INFINITY: Final = {"inf": "1e999", "-inf": "-1e999"}
FINITE: Final = {token: cell for cell, token in INFINITY.items()}
WORDS: Final = re.compile(r'[^,"\r\n]*')
"""What a cell of text may hold, as the recorder writes it."""
LIMIT: Final = 2**62
"""[ns] Stamps beyond this (146 years) are refused: they do not fit the format together with a start."""
FILES_OF_OURS: Final = (*FILE_OF_MESSAGE.values(), TOML, SESSION)
MAX_RECORD_BYTES: Final = 2**28  # [bytes] of a record or chunk; a damaged length must not eat the memory
MOST_TEXT: Final = 2**30
"""[bytes] of all tables in memory: two hours of a finger at 500 Hz, all that is said of it."""
LINE_COST: Final = 64  # [bytes] of a line besides its text
DAMAGE: Final = (ValueError, LookupError, RuntimeError, MemoryError, OverflowError, struct.error, zlib.error)
"""What the library raises on damaged bytes besides its own errors."""


def properties(kind: type[Message]) -> dict[str, dict[str, str]]:
    """Return column -> JSON schema of every column of the table of ``kind``, with its unit as description."""
    found = {"t": _number("s")}
    if kind is FingertipState:
        found["episode"] = _number("1")
        return found | {name: _number(quantity.unit) for name, quantity in CHANNELS.items()}
    for one in message_set().messages[kind].fields:
        found |= _property(one)
    return found


def json_schema(kind: type[Message], columns: Sequence[str]) -> bytes:
    """Return the JSON schema of the messages that carry ``columns``; nothing but the time is required."""
    known = properties(kind)
    chosen = {name: known[name] for name in columns}
    schema = {"title": f"vegrip.{kind.__name__}", "type": "object", "properties": chosen, "required": ["t"]}
    return json.dumps(schema).encode()


def to_json(cells: Mapping[str, str], known: Mapping[str, Mapping[str, str]]) -> bytes:
    """Return one row as a JSON object; ``known`` says which columns are numbers.

    Raises:
        RecordingError: a cell that is neither empty nor of its column's type.

    """
    members = [f'"{name}":{_token(name, cell, known[name])}' for name, cell in cells.items() if cell]
    return f"{{{','.join(members)}}}".encode()


def from_json(data: bytes, columns: Sequence[str]) -> str:
    """Return a JSON object as a line of the table with these ``columns``.

    Raises:
        RecordingError: not a JSON object, a member that is no column, or a value that no cell holds.

    """
    try:
        body = json.loads(data, parse_float=str, parse_int=str)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"is not JSON ({error})") from None
    if not isinstance(body, dict):
        raise RecordingError("is not a JSON object")
    unknown = sorted(body.keys() - set(columns))
    if unknown:
        raise RecordingError(f"has the unknown field {unknown[0]!r}")
    return ",".join(_cell(name, body.get(name, "")) for name in columns)


def _property(field: Field) -> dict[str, dict[str, str]]:
    if field.name in ("stamp", "finger"):  # the stamp is the time of the message, the finger its topic
        return {}
    if field.kind == "estimate":
        spread = {f"{field.name}_std": field.unit, f"{field.name}_valid": "1", f"{field.name}_age": "s"}
        return {name: _number(unit) for name, unit in ({field.name: field.unit} | spread).items()}
    named = field.enumeration is not None and not issubclass(field.enumeration, IntFlag)
    if named or field.kind in ("name", "text", "counts"):
        return {field.name: {"type": "string"}}
    return {field.name: _number(field.unit or "1")}


def _number(unit: str) -> dict[str, str]:
    return {"type": "number", "description": f"[{unit}]"}


def _token(name: str, cell: str, schema: Mapping[str, str]) -> str:
    if schema["type"] == "string":
        return json.dumps(cell)
    if cell in INFINITY or NUMBER.fullmatch(cell):
        return INFINITY.get(cell, cell)
    raise RecordingError(f"{name} is {cell!r}, which is not a number")


def _cell(name: str, value: Any) -> str:
    if not isinstance(value, str) or not WORDS.fullmatch(value):
        raise RecordingError(f"{name} is {value!r}, which is neither a number nor plain text")
    return FINITE.get(value, value)


@dataclass(frozen=True, slots=True)
class TextTable:
    """One table: where it lies in the folder, on which topic it goes, and its rows with their stamps [ns]."""

    file: str
    topic: str
    kind: type[Message]
    columns: tuple[str, ...]
    stamps: list[int]
    rows: list[Sequence[str]]


def tables_of(folder: Path, recordings: dict[Path, Recording]) -> Iterator[TextTable]:
    """Yield every table in ``folder``; ``recordings`` by their folder, read already."""
    start = 0
    for place, recording in recordings.items():
        start = recording.start
        yield _measured(folder, place, recording)
        for kind, name in FILE_OF_MESSAGE.items():
            path = place / name
            if kind not in (FingertipState, *OF_NODES) and path.exists():
                yield _said(folder, path, kind, recording.fingertip.name, start)
    for kind in OF_NODES:
        path = folder / FILE_OF_MESSAGE[kind]
        if path.exists():
            yield _said(folder, path, kind, "", start)


def read_all(folder: Path) -> dict[Path, Recording]:
    return {place: read_recording(place, announce=False) for place in finger_folders(folder)}


def _measured(folder: Path, place: Path, recording: Recording) -> TextTable:
    numbers = [recording.t, recording.episode, *recording.columns.values()]
    cells = [[exact_cell(value) for value in column.tolist()] for column in numbers]
    stamps = [_stamp(t, recording.start, str(place)) for t in recording.t.tolist()]
    file = (place / FILE_OF_MESSAGE[FingertipState]).relative_to(folder).as_posix()
    columns = ("t", "episode", *recording.columns)
    topic = _topic(FingertipState, recording.fingertip.name)
    return TextTable(file, topic, FingertipState, columns, stamps, list(zip(*cells, strict=True)))


def _said(folder: Path, path: Path, kind: type[Message], finger: str, start: int) -> TextTable:
    words = read_cells(path)
    columns = tuple(words)
    unknown = sorted(set(columns) - set(properties(kind)))
    if unknown or "t" not in columns:
        raise RecordingError(f"{path}: " + (f"unknown column {unknown[0]!r}" if unknown else "no column 't'"))
    stamps = [_stamp(_seconds(path, t), start, str(path)) for t in words["t"]]
    rows: list[Sequence[str]] = list(zip(*(words[name] for name in columns), strict=True))
    return TextTable(path.relative_to(folder).as_posix(), _topic(kind, finger), kind, columns, stamps, rows)


def _topic(kind: type[Message], finger: str) -> str:
    return message_set().messages[kind].topic.replace(PLACE, finger)


def _seconds(path: Path, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise RecordingError(f"{path}: the time {text!r} is not a number") from None


def _stamp(t: float, start: int, what: str) -> int:
    if not abs(t) * NS < LIMIT or not abs(start) < LIMIT:
        raise RecordingError(f"{what}: the time {t!r} s is too large for an MCAP file")
    return start + round(t * NS)


def write_mcap(folder: Path | str, path: Path | str) -> dict[Path, Recording]:
    """Write the recording or session in ``folder`` to the MCAP file ``path``; return what was read.

    Raises:
        RecordingError: no recording, a damaged table, or a file that cannot be written.
        UsageError: the library mcap is not installed.

    """
    folder, path = Path(folder), Path(path)
    library = bag_library("mcap.writer")
    recordings = read_all(folder)
    tables = list(tables_of(folder, recordings))
    with writing(path, RecordingError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part, part.open("wb") as file:
            writer = library.Writer(file, enable_data_crcs=True)
            writer.start(library="vegrip")
            for name, text in _descriptions(folder, recordings):
                writer.add_attachment(0, 0, name, "application/toml", text.encode())
            _write_tables(writer, tables)
            writer.finish()
    return recordings


def _descriptions(folder: Path, recordings: dict[Path, Recording]) -> Iterator[tuple[str, str]]:
    if (folder / SESSION).exists():
        yield SESSION, _utf8(folder / SESSION)
    for place, recording in recordings.items():
        yield (place / TOML).relative_to(folder).as_posix(), toml_text(recording)


def _utf8(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise RecordingError(f"{path}: is not a text file in UTF-8") from None


def _write_tables(writer: Any, tables: list[TextTable]) -> None:
    first = min((table.stamps[0] for table in tables), default=0)
    earlier = max(-first, 0)  # times in MCAP are unsigned: all are moved so that the first is zero
    streams = [_stream(writer, table) for table in tables]
    for stamp, channel, sequence, data in heapq.merge(*streams, key=lambda message: message[0]):
        log_time = stamp + earlier
        writer.add_message(channel, log_time, data, log_time, sequence)


def _stream(writer: Any, table: TextTable) -> Iterator[tuple[int, int, int, bytes]]:
    name = f"vegrip.{table.kind.__name__}"
    schema = writer.register_schema(name, "jsonschema", json_schema(table.kind, table.columns))
    about = {"file": table.file, "columns": ",".join(table.columns), "rows": str(len(table.rows))}
    channel = writer.register_channel(table.topic, "json", schema, about)
    known = properties(table.kind)
    for row, (stamp, cells) in enumerate(zip(table.stamps, table.rows, strict=True)):
        try:
            data = to_json(dict(zip(table.columns, cells, strict=True)), known)
        except RecordingError as error:
            raise RecordingError(f"{table.file}: row {row + 1}: {error}") from None
        yield stamp, channel, row, data


@dataclass(slots=True)
class _Table:
    file: str
    topic: str
    columns: list[str]
    rows: int
    lines: list[str] = field(default_factory=list)


def read_mcap(path: Path | str, folder: Path | str) -> dict[Path, Recording]:
    """Write what ``path`` holds to ``folder`` and return the recordings in it, by the folder of each.

    A message that is missing, out of order or damaged refuses the file: nothing is written then.

    Raises:
        RecordingError: not an MCAP file, damaged, or not written by vegrip; names topic and message.
        UsageError: the library mcap is not installed.

    """
    path, folder = Path(path), Path(folder)
    if folder.is_file() or (folder.exists() and any(folder.iterdir())):
        raise RecordingError(f"{folder}: is there already; choose another folder")
    with _records(path) as records:
        texts = _texts(path, records)
    with writing(folder, RecordingError):
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".vegrip-") as scratch:
            found = _unpacked(path, texts, Path(scratch) / folder.name)
            if folder.exists():
                folder.rmdir()
            (Path(scratch) / folder.name).rename(folder)
    return {folder / place: recording for place, recording in found.items()}


def _unpacked(path: Path, texts: Mapping[str, str], folder: Path) -> dict[Path, Recording]:
    folder.mkdir()
    for name, text in texts.items():
        (folder / name).parent.mkdir(exist_ok=True)
        write_whole(folder / name, text)
    try:
        found = read_all(folder)
    except RecordingError as error:
        raise RecordingError(str(error).replace(str(folder), str(path))) from None
    return {place.relative_to(folder): recording for place, recording in found.items()}


@contextmanager
def _records(path: Path) -> Iterator[Iterator[Any]]:
    """Read from front to end: that is how the library checks the sums over all that is in the file."""
    library = bag_library("mcap.stream_reader")
    damage = (bag_library("mcap.exceptions").McapError, bag_library("zstandard").ZstdError, *DAMAGE)
    try:
        with reading(path, RecordingError), path.open("rb") as file:
            reader = library.StreamReader(
                file, validate_crcs=True, record_size_limit=MAX_RECORD_BYTES, emit_chunks=True
            )
            yield _unchunked(path, reader.records)
    except damage as error:
        raise RecordingError(
            f"{path}: is not a whole MCAP file ({str(error) or type(error).__name__})"
        ) from None


def _unchunked(path: Path, records: Iterator[Any]) -> Iterator[Any]:
    kinds, library = bag_library("mcap.records"), bag_library("mcap.stream_reader")
    for record in records:
        if not isinstance(record, kinds.Chunk):
            yield record
            continue
        data = _inflated(path, record.compression, record.data)
        yield from library.breakup_chunk(replace(record, compression="", data=data), validate_crc=True)


def _inflated(path: Path, compression: str, data: bytes) -> bytes:
    if compression == "zstd":
        # a reader stops where the index says, whatever size the frame claims
        data = bag_library("zstandard").ZstdDecompressor().stream_reader(data).read(MAX_RECORD_BYTES + 1)
    elif compression == "lz4":
        data = bag_library("lz4.frame").LZ4FrameDecompressor().decompress(data, MAX_RECORD_BYTES + 1)
    elif compression:
        raise RecordingError(f"{path}: is compressed with {compression!r}, which is not known")
    if len(data) > MAX_RECORD_BYTES:
        raise RecordingError(f"{path}: a chunk of it unpacks to more than {MAX_RECORD_BYTES} bytes")
    return data


def _texts(path: Path, records: Iterator[Any]) -> dict[str, str]:
    kinds = bag_library("mcap.records")
    texts: dict[str, str] = {}
    tables: dict[int, _Table] = {}
    room = MOST_TEXT
    for record in records:
        if isinstance(record, kinds.Attachment):
            texts[_safe(path, record.name)] = record.data.decode()
        elif isinstance(record, kinds.Channel) and record.id not in tables:  # they are repeated at the end
            tables[record.id] = _table(path, record)
        elif isinstance(record, kinds.Message):
            room -= _add_message(path, tables[record.channel_id], record)
            if room < 0:
                raise RecordingError(
                    f"{path}: holds more than {MOST_TEXT} bytes of tables; keep it as a folder"
                )
    if not tables:
        raise RecordingError(f"{path}: holds no recording; it was not written by vegrip")
    return texts | {table.file: _table_text(path, table) for table in tables.values()}


def _table(path: Path, channel: Any) -> _Table:
    about = channel.metadata
    if not {"file", "columns", "rows"} <= about.keys():
        raise RecordingError(
            f"{path}: {channel.topic} was not written by vegrip; a bag of ROS needs a --map-file"
        )
    return _Table(_safe(path, about["file"]), channel.topic, about["columns"].split(","), int(about["rows"]))


def _add_message(path: Path, table: _Table, message: Any) -> int:
    """Add ``message`` to its table; return what that costs [bytes]."""
    where = f"{path}: {table.topic}: message {len(table.lines)}"
    if message.sequence != len(table.lines):
        raise RecordingError(f"{where} is missing; in its place stands {message.sequence}")
    try:
        table.lines.append(from_json(message.data, table.columns))
    except RecordingError as error:
        raise RecordingError(f"{where} {error}") from None
    return len(table.lines[-1]) + LINE_COST


def _table_text(path: Path, table: _Table) -> str:
    if len(table.lines) != table.rows:
        raise RecordingError(f"{path}: {table.topic}: holds {len(table.lines)} of {table.rows} messages")
    return "\n".join([",".join(table.columns), *table.lines]) + "\n"


def _safe(path: Path, name: str) -> str:
    """Return ``name`` if it is a file of ours, at most one folder down: none may lead out of it."""
    *places, file = PurePath(name).parts or ("",)
    if file not in FILES_OF_OURS or len(places) > 1 or {"..", PurePath(name).anchor} & set(places):
        raise RecordingError(f"{path}: holds the unexpected file {name!r}; it was not written by vegrip")
    return name
