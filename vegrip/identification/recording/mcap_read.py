"""From an MCAP file of :mod:`~vegrip.identification.recording.mcap_write` to the folder it was made from."""

import struct
import tempfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Any, Final

from vegrip.errors import RecordingError
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.extras import bag_library
from vegrip.identification.recording.folder import TOML
from vegrip.identification.recording.mcap_cells import from_json
from vegrip.identification.recording.mcap_tables import read_all
from vegrip.identification.recording.rows import FILE_OF_MESSAGE
from vegrip.identification.recording.writer import SESSION
from vegrip.whole_file import write_whole

FILES_OF_OURS: Final = (*FILE_OF_MESSAGE.values(), TOML, SESSION)
MAX_RECORD_BYTES: Final = 2**28  # [bytes] of a record or chunk; a damaged length must not eat the memory
MOST_TEXT: Final = (
    2**30
)  # [bytes] of all tables in memory: two hours of a finger at 500 Hz, all that is said of it
LINE_COST: Final = 64  # [bytes] of a line besides its text
DAMAGE: Final = (ValueError, LookupError, RuntimeError, MemoryError, OverflowError, struct.error, zlib.error)
"""What the library raises on damaged bytes besides its own errors."""


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
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".vegrip-") as scratch:
            found = _unpacked(path, texts, Path(scratch) / folder.name)
            if folder.exists():
                folder.rmdir()
            (Path(scratch) / folder.name).rename(folder)
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be written ({error.strerror or error})") from None
    return {folder / place: recording for place, recording in found.items()}


def _unpacked(path: Path, texts: Mapping[str, str], folder: Path) -> dict[Path, Recording]:
    """Write ``texts`` into ``folder`` and read them; return the recordings by their place in it."""
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
        with path.open("rb") as file:
            reader = library.StreamReader(
                file, validate_crcs=True, record_size_limit=MAX_RECORD_BYTES, emit_chunks=True
            )
            yield _unchunked(path, reader.records)
    except FileNotFoundError:
        raise RecordingError(f"{path}: there is no such file") from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror or error})") from None
    except damage as error:
        raise RecordingError(
            f"{path}: is not a whole MCAP file ({str(error) or type(error).__name__})"
        ) from None


def _unchunked(path: Path, records: Iterator[Any]) -> Iterator[Any]:
    """Yield ``records`` and those in their chunks, none of which is more than ``MAX_RECORD_BYTES``."""
    kinds, library = bag_library("mcap.records"), bag_library("mcap.stream_reader")
    for record in records:
        if not isinstance(record, kinds.Chunk):
            yield record
            continue
        data = _inflated(path, record.compression, record.data)
        yield from library.breakup_chunk(replace(record, compression="", data=data), validate_crc=True)


def _inflated(path: Path, compression: str, data: bytes) -> bytes:
    if compression == "zstd":
        # a reader stops where it is told, whatever size the frame claims
        data = bag_library("zstandard").ZstdDecompressor().stream_reader(data).read(MAX_RECORD_BYTES + 1)
    elif compression == "lz4":
        data = bag_library("lz4.frame").LZ4FrameDecompressor().decompress(data, MAX_RECORD_BYTES + 1)
    elif compression:
        raise RecordingError(f"{path}: is compressed with {compression!r}, which is not known")
    if len(data) > MAX_RECORD_BYTES:
        raise RecordingError(f"{path}: a chunk of it unpacks to more than {MAX_RECORD_BYTES} bytes")
    return data


def _texts(path: Path, records: Iterator[Any]) -> dict[str, str]:
    """Return file -> its text of every file that went into ``path``."""
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
            room -= _take(path, tables[record.channel_id], record)
            if room < 0:
                raise RecordingError(
                    f"{path}: holds more than {MOST_TEXT} bytes of tables; keep it as a folder"
                )
    if not tables:
        raise RecordingError(f"{path}: holds no recording; it was not written by vegrip")
    return texts | {table.file: _text(path, table) for table in tables.values()}


def _table(path: Path, channel: Any) -> _Table:
    about = channel.metadata
    if not {"file", "columns", "rows"} <= about.keys():
        raise RecordingError(
            f"{path}: {channel.topic} was not written by vegrip; a bag of ROS needs a --map-file"
        )
    return _Table(_safe(path, about["file"]), channel.topic, about["columns"].split(","), int(about["rows"]))


def _take(path: Path, table: _Table, message: Any) -> int:
    """Add ``message`` to its table; return what that costs [bytes]."""
    where = f"{path}: {table.topic}: message {len(table.lines)}"
    if message.sequence != len(table.lines):
        raise RecordingError(f"{where} is missing; in its place stands {message.sequence}")
    try:
        table.lines.append(from_json(message.data, table.columns))
    except RecordingError as error:
        raise RecordingError(f"{where} {error}") from None
    return len(table.lines[-1]) + LINE_COST


def _text(path: Path, table: _Table) -> str:
    if len(table.lines) != table.rows:
        raise RecordingError(f"{path}: {table.topic}: holds {len(table.lines)} of {table.rows} messages")
    return "\n".join([",".join(table.columns), *table.lines]) + "\n"


def _safe(path: Path, name: str) -> str:
    """Return ``name`` if it is a file of ours, at most one folder down: none may lead out of it."""
    *places, file = PurePath(name).parts or ("",)
    if file not in FILES_OF_OURS or len(places) > 1 or {"..", PurePath(name).anchor} & set(places):
        raise RecordingError(f"{path}: holds the unexpected file {name!r}; it was not written by vegrip")
    return name
